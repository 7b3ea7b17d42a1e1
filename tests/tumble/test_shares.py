"""Where a command runs its tasks, by its options, by TUMBLE_SCHEDULER and in Python: what cannot be is one line."""

import pytest

import tumble as package

WORDS = ("compare", "die-straight", "-e", "tumble:rk4")
FAR = "10.0.0.1:8786"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--workers", "1", "--scheduler", "127.0.0.1:1"), "without --scheduler"),
        (("--shard", "1/2", "--workers", "2"), "--shard runs here: leave out --scheduler and --workers"),
        (("--shard", "1/2", "--scheduler", "127.0.0.1:1"), "--shard runs here: leave out --scheduler and --workers"),
        (("--tls-ca", "ca.pem"), "are for --scheduler tls://HOST:PORT"),
        (("--scheduler", FAR), f"--scheduler {FAR}: whoever reaches this port can run code"),
    ],
)
def test_options_that_exclude_each_other_are_refused(more, said, tumble):
    done = tumble(*WORDS, *more)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert said in done.stderr


def test_the_scheduler_of_the_environment_is_a_default(tumble, monkeypatch):
    monkeypatch.setenv("TUMBLE_SCHEDULER", FAR)
    assert f"--scheduler {FAR}: whoever reaches this port" in tumble(*WORDS).stderr
    assert tumble(*WORDS, "--shard", "1/1").returncode == 0, "a shard runs here"
    assert tumble("scenes", "die-straight").returncode == 0, "this command has no scheduler"


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"workers": 0}, "--workers 0: must be at least 1"),
        ({"workers": 2, "scheduler": "127.0.0.1:1"}, "without --scheduler"),
        ({"scheduler": FAR}, "whoever reaches this port"),
        ({"tls": {"ca": "ca.pem"}}, "are for --scheduler tls://HOST:PORT"),
        ({"shard": (1, 2), "workers": 2}, "without scheduler and workers"),
    ],
)
def test_a_session_refuses_the_same(given, said):
    with pytest.raises(package.UserError) as refused, package.session(**given):
        pass
    assert said in str(refused.value)
