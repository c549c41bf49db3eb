"""Test runners that nobody here wrote, run as they are: what they report is what came of their tests."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from trackmarshal.junit import reading

pytestmark = pytest.mark.acceptance

CMAKE = """cmake_minimum_required(VERSION 3.21)
project(door NONE)
enable_testing()
add_test(NAME opens COMMAND true)
add_test(NAME shuts COMMAND false)
add_test(NAME skips COMMAND sh -c "exit 77")
set_tests_properties(skips PROPERTIES SKIP_RETURN_CODE 77)
add_test(NAME off COMMAND true)
set_tests_properties(off PROPERTIES DISABLED TRUE)
add_test(NAME gone COMMAND /no/such/program)
add_test(NAME slow COMMAND sleep 5)
set_tests_properties(slow PROPERTIES TIMEOUT 1)
"""
NODE = """const {test, describe, it} = require('node:test'); const assert = require('assert');
test('opens S-1-B-1', () => {});
describe('door', () => {
  it('shuts', () => assert.equal(1, 2));
  it('skips', {skip: 'no lock'}, () => {});
  it('later', {todo: true}, () => {});
});
"""


def outcomes(path: Path) -> dict[str, str]:
    return {test.name: test.outcome for test in reading.read(path, path.name)}


@pytest.mark.skipif(shutil.which("ctest") is None, reason="no CTest")
def test_ctest(tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text(CMAKE, "utf-8")
    subprocess.run(["cmake", "-B", "build", "."], cwd=tmp_path, check=True, capture_output=True)
    done = subprocess.run(
        ["ctest", "--output-junit", "out.xml"], cwd=tmp_path / "build", check=False, capture_output=True
    )
    assert done.returncode != 0
    assert outcomes(tmp_path / "build" / "out.xml") == {
        "opens": "passed", "shuts": "failed", "skips": "skipped", "off": "skipped", "gone": "skipped", "slow": "failed",
    }  # fmt: skip


@pytest.mark.skipif(shutil.which("node") is None, reason="no Node")
def test_node(tmp_path: Path) -> None:
    (tmp_path / "door.test.js").write_text(NODE, "utf-8")
    words = ["node", "--test", "--test-reporter=junit", "door.test.js"]
    done = subprocess.run(words, cwd=tmp_path, check=False, capture_output=True)
    (tmp_path / "out.xml").write_bytes(done.stdout)
    assert outcomes(tmp_path / "out.xml") == {
        "opens S-1-B-1": "passed",
        "shuts": "failed",
        "skips": "skipped",
        "later": "skipped",
    }
