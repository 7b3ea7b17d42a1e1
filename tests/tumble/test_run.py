"""`tumble run` of many throws: some at a time, and the same text."""

from dataclasses import replace

import numpy as np

from tumble.commands import run
from tumble.compare.run.running_engines import launched
from tumble.scenarios.read import read_scene


def test_an_ensemble_is_flown_and_written_some_throws_at_a_time(monkeypatch):
    scene = read_scene("many-throws")
    with launched(["tumble:rk4"]) as (running_engine,):
        whole = list(run.pieces(running_engine, scene, scene.step))
        # Room for five throws of 24: the last part has four.
        monkeypatch.setattr(run, "NUMBERS", 5 * len(scene.rows) * (13 + scene.body.points.size))
        parts = list(run.pieces(running_engine, scene, scene.step))
    assert len(whole) == 1
    assert len(parts) == 5
    assert "".join(parts) == whole[0]
    lines = whole[0].splitlines()
    assert lines[0].startswith("member,t_s,")
    assert [int(line.split(",")[0]) for line in lines[1:]] == np.repeat(np.arange(24), len(scene.rows)).tolist()


def test_what_is_said_of_the_parts_is_said_once(capsys, monkeypatch):
    scene = read_scene("many-throws")
    monkeypatch.setattr(run, "NUMBERS", 1)
    with launched(["tumble:rk4"]) as (running_engine,):
        # So fast that numbers overflow.
        assert len(list(run.pieces(running_engine, replace(scene, start=scene.start[:3] * 1e200), 0.5))) == 3
    said = capsys.readouterr().err.splitlines()
    assert len(said) == len(set(said)) == 1
    assert "diverged at" in said[0]
