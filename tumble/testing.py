"""For tests of engines with pytest: one test a check and scene, and a fixture that guards a baseline.

pytest loads this module where Tumble is installed.  Heavy parts load when a test uses them.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import pytest

CONTRACT_SCENE = "contract"
# Errors at the scene's step and at a half and a quarter of it: they fall, or are as small as rounding [of the body].
HALVINGS, FALLS, ROUNDING = 2, 0.8, 1e-9


def parametrize_with_laws(
    contestant: Any, scenes: Iterable[Any] = (), *, expected_failures: Mapping[str, str] | None = None
) -> pytest.MarkDecorator:
    """Make one test for each check of an engine.

    The test takes an argument `law` and calls it.  The checks of the engine contract have the scene "contract"; on each
    scene given, the engine must finish, and come nearer to the reference solution as the step is halved.  A scene with
    a plane asks for the contract's checks of contact instead of the latter.

    Parameters
    ----------
    contestant : a function as `tumble.engine` takes it, ENGINE:METHOD or a path.
    scenes : names, paths, tables as in TOML, or `tumble.Scene`.
    expected_failures : check -> reason.  Such a check must fail: if it passes, its test fails.

    Returns
    -------
    pytest.MarkDecorator
        Test ids are ENGINE-SCENE-CHECK.

    Raises
    ------
    UserError
        For an expected failure of a check that there is not.
    """
    from tumble.api.scene import Scene
    from tumble.compare.engines import CHECKS, CONTACT_CHECKS
    from tumble.scenarios.refusal import UserError

    failures = dict(expected_failures or {})
    asked = [Scene.of(scene) for scene in scenes]
    in_contact = {scene.name for scene in asked if scene.question.plane is not None}
    names = {**CHECKS, **(CONTACT_CHECKS if in_contact else {})}
    laws = [Law(contestant, CONTRACT_SCENE, None, name) for name in names]
    laws += [
        Law(contestant, scene.name, scene, name)
        for scene in asked
        for name in (("finishes",) if scene.name in in_contact else ON_A_SCENE)
    ]
    if unknown := set(failures) - {law.name for law in laws}:
        there = ", ".join(dict.fromkeys(law.name for law in laws))
        raise UserError(f"expected_failures: no check {min(unknown)!r}; there are {there}")
    return pytest.mark.parametrize(
        "law",
        [
            pytest.param(
                law,
                id=law.id,
                marks=[pytest.mark.xfail(reason=failures[law.name], strict=True, raises=AssertionError)]
                if law.name in failures
                else (),
            )
            for law in laws
        ],
    )


class Law:
    """One check of one engine; calling it raises AssertionError where the engine fails it, and skips what it has not.

    Parameters
    ----------
    contestant : as `parametrize_with_laws` has it.
    scene_name : for the test's id.
    question : the scene; None for a check of the engine contract.
    name : of the check.
    """

    def __init__(self, contestant: Any, scene_name: str, question: Any, name: str) -> None:
        self._contestant, self._scene, self.name = contestant, question, name
        self.id = "-".join(slug(part) for part in (engine_name(contestant), scene_name, name))

    def __call__(self) -> None:
        """Make the check."""
        if self._scene is None:
            contract(self._contestant, self.name)
        else:
            ON_A_SCENE[self.name](self._contestant, self._scene)

    def __repr__(self) -> str:
        return self.id


def contract(contestant: Any, name: str) -> None:
    """Make one check of the engine contract.

    Parameters
    ----------
    contestant : as `parametrize_with_laws` has it.
    name : of the check.

    Raises
    ------
    AssertionError
        Where a method of the engine fails it.
    """
    from tumble.api.engines import check_engine

    table = check_engine(contestant, progress=False, only=name).table
    failed = table[table["outcome"] == "failed"]
    assert not len(failed), "; ".join(
        f"{method}: {why}" for method, why in zip(failed["method"], failed["why"], strict=True)
    )
    if "passed" not in set(table["outcome"]):
        for why in table.loc[table["outcome"] == "known", "why"]:
            pytest.xfail(str(why))  # as the engine's file states
        pytest.skip(str(table["why"].iloc[0]))


def finishes(contestant: Any, scene: Any) -> None:
    """Check that every method finishes the scene without a finding of its audit.

    Parameters
    ----------
    contestant : as `parametrize_with_laws` has it.
    scene : tumble.Scene.

    Raises
    ------
    AssertionError
        Where one does not.
    """
    runs = runs_of(contestant, scene)
    bad = runs[runs["status"] != "ok"]
    assert not len(bad), "; ".join(f"{row['method']}: {row['status']} {row['why']}" for _, row in bad.iterrows())


def converges(contestant: Any, scene: Any) -> None:
    """Check that every method comes nearer to the reference solution as the step is halved.

    Parameters
    ----------
    contestant : as `parametrize_with_laws` has it.
    scene : tumble.Scene.

    Raises
    ------
    AssertionError
        Where the error of one stays or grows, and is not as small as rounding leaves.
    """
    import tumble

    size, step = scene.question.body.reach, scene.question.step
    with tumble.session():
        steps = [step / 2**halving for halving in range(HALVINGS + 1)]
        tables = [runs_of(contestant, scene, dt) for dt in steps]
    errors = [dict(zip(table["method"], table["max_error_m"], strict=True)) for table in tables]
    for method, first in errors[0].items():
        last = errors[-1][method]
        assert last <= max(FALLS**HALVINGS * first, ROUNDING * size), (
            f"{method}: error {first:.3g} m at a step of {steps[0]:.3g} s, {last:.3g} m at {steps[-1]:.3g} s"
        )


def runs_of(contestant: Any, scene: Any, dt: float | None = None) -> Any:
    """Run a scene with every method of an engine, and skip the test where the engine has no force for the scene.

    Parameters
    ----------
    contestant : as `parametrize_with_laws` has it.
    scene : tumble.Scene.
    dt : step [s]; None: the scene's own.

    Returns
    -------
    pandas.DataFrame
        The table `runs` without the methods that are skipped.
    """
    import tumble

    runs = tumble.compare(scene, contestant, dt=dt, film=False, progress=False).runs
    able = runs[runs["status"] != "skipped"]
    if not len(able):
        pytest.skip(str(runs["why"].iloc[0]))
    return able


ON_A_SCENE: dict[str, Callable[[Any, Any], None]] = {"finishes": finishes, "converges on it": converges}


def engine_name(contestant: Any) -> str:
    """Return what a contestant is called in test ids.

    Parameters
    ----------
    contestant : as `parametrize_with_laws` has it.

    Returns
    -------
    str
    """
    if isinstance(contestant, str | Path):
        return Path(str(contestant)).stem
    return str(getattr(contestant, "name", None) or getattr(contestant, "__name__", type(contestant).__name__))


def slug(text: str) -> str:
    """Return a text as a part of a test id: letters, digits and hyphens.

    Parameters
    ----------
    text : any.

    Returns
    -------
    str
    """
    return re.sub(r"[^A-Za-z0-9]+", "-", text).strip("-")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add --tumble-accept."""
    parser.getgroup("tumble").addoption(
        "--tumble-accept", action="store_true", help="write the baselines of tumble_check; the tests still fail"
    )


@pytest.fixture
def tumble_check(request: pytest.FixtureRequest) -> Callable[..., Any]:
    """Compare an engine with a baseline beside the test file: `tumble_check("two-hits", mine, times=False)`.

    The baseline is the folder `tumble-baselines/TEST` beside the test file.  `pytest --tumble-accept` writes it, and
    fails the test: look at the change, and commit it if it is intended.
    """

    def check(scenes: Any, contestants: Any, **options: Any) -> Any:
        import tumble

        folder = request.path.parent / "tumble-baselines" / slug(f"{request.path.stem}-{request.node.name}")
        accept = bool(request.config.getoption("--tumble-accept"))
        if not accept and not (folder / "conditions.csv").exists():
            pytest.fail(
                f"no baseline in {folder}: run pytest --tumble-accept once, and commit the folder", pytrace=False
            )
        found = tumble.check(scenes, contestants, baseline=folder, accept=accept, progress=False, **options)
        if accept:
            pytest.fail(
                f"baseline written to {folder}: review it, commit it, and run without --tumble-accept", pytrace=False
            )
        if not found:
            pytest.fail(found.summary, pytrace=False)
        return found

    return check
