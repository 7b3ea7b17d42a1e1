"""The end of each command's `--help`: examples to copy, and the units."""

EXAMPLES: dict[str, tuple[str, ...]] = {
    "scenes": ("tumble scenes", "tumble scenes brick-tumble > mine.toml"),
    "columns": ("tumble columns", "tumble columns runs"),
    "engines": (
        "tumble engines",
        "tumble engines --install drake mujoco@3.10.0",
        "tumble engines --template cpp",
        "tumble engines --check ./mine.py",
    ),
    "run": ("tumble run brick-tumble -e mujoco:rk4 --dt 0.002 -o brick.csv",),
    "compare": (
        "tumble compare table-4-1",
        "tumble compare brick-tumble -e mujoco:rk4 -e pybullet --dt 0.002 -o brick",
    ),
    "sweep": ("tumble sweep yardstick -e tumble:rk4 -e mujoco:rk4 -o cost",),
    "advise": ("tumble advise two-hits --tolerance 1e-3 -e tumble:rk4 -e mujoco",),
    "stability": ("tumble stability tether-undamped -e mujoco:rk4 -e mujoco:rk4+held -o stiff",),
    "grade": (
        "tumble grade mine.csv --scene table-4-1",
        "tumble grade mine.csv --scene brick-tumble --map Time=t_s --map pos_x=x_cm",
        "tumble grade unity.csv --scene brick-tumble --axes unity --euler unity",
    ),
    "check": (
        "tumble check two-hits -e ./mine.py --no-times --accept -o baseline",
        "tumble check -e ./mine.py --baseline baseline -o checked",
    ),
    "releases": (
        "tumble releases mujoco",
        "tumble releases mujoco --from 3.6.0 --install -o ledger",
    ),
    "merge": ("tumble merge shard-1-of-2 shard-2-of-2 -o cost",),
    "ablate": ("tumble ablate die-straight -e tumble:rk4 -e mujoco:rk4",),
    "lab": ("tumble lab", "tumble lab table-4-1 -e mujoco:euler -e ./mine.py --no-open"),
    "report": ("tumble report dzhanibekov ./brick.toml -o dzhanibekov.html",),
}
UNITS = """\
Units are SI: m, s, kg, rad; N s for impulses.  Results go to standard output,
notes and progress to standard error."""


def epilog(command: str) -> str:
    """Return the text below a command's options."""
    examples = EXAMPLES.get(command, ())
    head = [f"example{'s' * (len(examples) > 1)}:"] if examples else []
    return "\n".join((*head, *(f"  {line}" for line in examples), *[""] * bool(examples), UNITS))
