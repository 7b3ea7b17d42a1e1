import pytest
from hypothesis import given
from hypothesis import strategies as st

from tumble.compare.run.asked import wanted
from tumble.compare.run.contestant import BadEngine, Contestant, MethodName

WORDS = st.from_regex(r"[a-z][a-z0-9-]{0,8}", fullmatch=True)
METHODS = st.builds(
    MethodName, WORDS, st.lists(WORDS, max_size=3).map(tuple), st.sampled_from(("", "1e-9", "0.001", "1e-06"))
)
ENGINES = st.tuples(WORDS, st.sampled_from(("", "3.10.0", "1!2.0+cu12"))) | st.tuples(
    st.sampled_from(("./mine.py", "a:b@c/mine.toml", "C:\\x\\mine.py")), st.just("")
)


@given(ENGINES, METHODS | st.just(MethodName()))
def test_a_name_comes_back(engine, method):
    name, release = engine
    contestant = Contestant(name, release, method)
    assert Contestant.parse(str(contestant)) == contestant
    assert Contestant.of(contestant.engine_release, str(method)) == contestant


@given(st.text())
def test_any_method_keeps_its_text(text):
    assert str(MethodName.parse(text)) == text


@given(st.text())
def test_any_text_names_a_contestant_or_is_refused_in_one_line(text):
    try:
        found = Contestant.parse(text)
    except BadEngine:
        return
    assert text in (str(found), f"{found}:"), "a method may be a colon"


def test_the_parts_of_a_full_name():
    found = Contestant.parse("mujoco@3.10.0:rk4+held+defaults@1e-9")
    assert (found.engine, found.release, found.engine_release) == ("mujoco", "3.10.0", "mujoco@3.10.0")
    assert found.method == MethodName("rk4", ("held", "defaults"), "1e-9")
    assert str(found.without_tolerance) == "mujoco@3.10.0:rk4+held+defaults"


@pytest.mark.parametrize("text", ["", ":rk4", "@1.0:rk4", "mujoco@:rk4", "mujoco@../x", "nothing:rk4", "./no.py:m"])
def test_a_bad_name_is_refused_in_one_line(text):
    with pytest.raises(BadEngine) as refused:
        wanted([text])
    assert "\n" not in str(refused.value)
