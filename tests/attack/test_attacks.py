"""A few of each kind of attack; `make attack` does all of them, many times."""

import damaged
import engine_files
import kills
import pytest
import starved


@pytest.mark.parametrize("name", engine_files.ENGINE_FILES)
def test_an_engine_file_does_its_worst(tmp_path, name):
    engine_files.attack(tmp_path, name)


@pytest.mark.parametrize("name", starved.STATES)
def test_a_starved_machine_is_told_in_a_line_or_done_without(tmp_path, name):
    starved.attack(tmp_path, name)


@pytest.mark.parametrize("name", damaged.DAMAGE)
def test_a_damaged_folder_is_read_or_refused(tmp_path, name):
    damaged.attack(tmp_path, name, share=3)


@pytest.mark.parametrize("seed", range(1000, 1005))
def test_a_kill_leaves_all_or_nothing(tmp_path, seed):
    kills.attack(tmp_path, seed)
