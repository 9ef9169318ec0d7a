# SPDX-License-Identifier: MIT
"""Scenarios that many tests start from, and the reproduction of a study."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from commands import gyrostat
from hypothesis import settings
from numpy.typing import NDArray

import gyrostat as gs

if TYPE_CHECKING:
    from selenium import webdriver

# Fixed examples in every run; no deadline, machines are shared.
settings.register_profile("gyrostat", derandomize=True, deadline=None)
settings.load_profile("gyrostat")


LONGEST_FIRST = (
    *("export_stacks", "export_fmu", "export", "campaign_runs", "tutorials", "design_loop", "li2018", "wang2023"),
    *("tutorial", "clusters", "docs", "package", "cao2023", "design_bandwidth", "missions", "verify", "sequential"),
)


def pytest_configure(config: pytest.Config) -> None:
    """Workers take files in the order in which they are collected, not those with many tests first."""
    config.option.loadscopereorder = False


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files first: none is left for the end, when the other workers have nothing to do."""
    places = {f"test_{name}": i for i, name in enumerate(LONGEST_FIRST)}
    items.sort(key=lambda item: places.get(item.path.stem, len(places)))


@pytest.fixture(scope="session")
def scenario() -> gs.Scenario:
    """FTC-4RW for 30 s, wheel 2 at 40 % from 5 s: short, with a fault, noise and a disturbance."""
    return gs.Scenario(
        vehicle=gs.vehicle.ftc_4rw(),
        initial=gs.Initial(mrp=(0.1, 0.2, -0.3), omega_BN_B=(0.01, -0.02, 0.03)),
        controller=gs.controller("mrp_feedback"),
        faults=[gs.faults.LossOfEffectiveness(actuator=2, t_on=5.0, remaining=0.4)],
        disturbances=[gs.disturbances.Constant(torque_B=(1e-3, -2e-3, 1.5e-3))],
        sensors=[gs.sensors.Gyro(noise=1e-6)],
        duration=30.0,
        dt=0.01,
        seed=7,
    )


@pytest.fixture(scope="session")
def result(scenario: gs.Scenario) -> gs.Result:
    """What flying it gives."""
    return scenario.run()


@pytest.fixture(scope="session")
def columns_of() -> Callable[[str], dict[str, NDArray[np.float64]]]:
    """Columns by name of a file of ``tests/golden``, named without its ending."""

    def read(name: str) -> dict[str, NDArray[np.float64]]:
        text = (Path(__file__).parents[1] / "golden" / f"{name}.csv").read_text()
        lines = [line for line in text.splitlines() if not line.startswith("#")]
        rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
        return dict(zip(lines[0].split(","), rows.T, strict=True))

    return read


@pytest.fixture(scope="module")
def report(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What ``gyrostat reproduce --out`` leaves for the module's ``PAPER``, with its JSON output in ``out.json``."""
    folder = tmp_path_factory.mktemp("report")
    done = gyrostat("reproduce", request.module.PAPER, "--json", "--data", "--out", folder)
    (folder / "out.json").write_text(done.stdout)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr
    return folder


@pytest.fixture(scope="module")
def claims(report: Path) -> dict[str, Any]:
    """What ``--json`` printed."""
    return json.loads((report / "out.json").read_text())


_flags = (
    "headless",
    "no-sandbox",
    "disable-gpu",
    "disable-quic",
    "no-first-run",
    "disable-background-networking",
    "disable-component-update",
    "disable-sync",
    "window-size=1400,1000",
)


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    """Debian's Chromium; it logs what a page complains about."""
    from selenium import webdriver

    browser, remote = shutil.which("chromium"), shutil.which("chromedriver")
    if browser is None or remote is None:
        pytest.fail("these tests need a browser: apt-get install chromium chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for flag in (*_flags, f"user-data-dir={tmp_path_factory.mktemp('chromium')}"):
        options.add_argument(f"--{flag}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    chrome = webdriver.Chrome(options=options, service=webdriver.ChromeService(remote))
    yield chrome
    chrome.quit()
