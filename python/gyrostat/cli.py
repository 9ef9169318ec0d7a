# SPDX-License-Identifier: MIT
"""The command ``gyrostat``.

Exit status: 0 done, 1 a claim or check failed, 2 bad input, 3 a run ended early or flew without a command, 4 no
verdict on a requirement, 5 a campaign found the disk full.
"""

from __future__ import annotations

import io
import math
import os
import shlex
import signal
import sys
import threading
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from gyrostat import _core, cli_campaign, cli_dataset, cli_survival, cli_verification, printing, toml
from gyrostat.errors import InputError, suggestion
from gyrostat.files import abandon, checked_target, made_folder, write_text
from gyrostat.old_names import current
from gyrostat.scenario import Scenario, shipped
from gyrostat.text import one_line, unescaped

if TYPE_CHECKING:
    from gyrostat.design import Finding
    from gyrostat.papers import Paper, Reproduction
    from gyrostat.plots import Figure
    from gyrostat.results import Result

app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="""Fault-tolerant spacecraft attitude control: fly a spacecraft whose actuators fail, and keep it pointing.

Start with `gyrostat new my.toml` and `gyrostat run my.toml`, look around with `gyrostat list` and
`gyrostat describe`, and compare published methods with `gyrostat reproduce`.""",
)

Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
ScenarioName = Annotated[str, typer.Argument(help="A TOML file, or a shipped scenario (`gyrostat list scenario`).")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value first, e.g. `observer.lambda1=2`. Repeatable."),
]
SingleFile = Annotated[bool, typer.Option("--single-file", help="Put all scripts into the page (5 MB).")]


class _Interrupted(BaseException):
    """Ctrl-C; typer makes something of its own of a KeyboardInterrupt."""


_interrupted, _told = threading.Event(), threading.Event()


def main() -> None:
    """Entry point: every foreseen problem is one line on stderr."""
    for stream in (sys.stdout, sys.stderr):  # whatever the terminal can show: no name or title is too strange to print
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    warnings.simplefilter("once", FutureWarning)  # old names
    warnings.showwarning = lambda message, *_, **__: printing.warning(message)
    warnings.simplefilter("ignore", RuntimeWarning)  # of numpy: what overflows is seen in what is printed
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, _interrupt)
        _watch_for_interruption()
    try:
        status = app(standalone_mode=False)
        sys.stdout.flush()
    except (_Interrupted, Exception) as error:
        status = _status_of(error)
    sys.exit(status if isinstance(status, int) else 0)


def _status_of(error: BaseException) -> int:
    """Say in one line what ended the command; what nobody foresaw is raised again."""
    if _interrupted.is_set():  # Python makes other errors of one that is raised while it makes a class
        return _say_interrupted()
    if isinstance(error, InputError):
        return printing.complain(str(error), 2)
    if isinstance(error, OSError):  # of the output; files have said their name already
        _drop_output()
        what = f"{error.filename or 'output'}: {(error.strerror or str(error)).lower()}"
        return 1 if isinstance(error, BrokenPipeError) else printing.complain(what, 2)
    if isinstance(error, MemoryError):
        return printing.complain("there is not enough memory for that", 2)
    usage = getattr(error, "format_message", None)  # command line errors of typer, which has moved their class about
    if usage is None:
        raise error
    said = one_line(usage())
    return printing.complain(f"{said} See 'gyrostat --help'.", 2) if said else 2  # help is printed already


def _interrupt(*_: object) -> NoReturn:
    _interrupted.set()
    raise _Interrupted


def _say_interrupted() -> int:
    _told.set()
    return printing.complain("interrupted", 130)


def _watch_for_interruption(patience: float = 1.5) -> None:
    """End the process when Ctrl-C has not ended it after `patience` seconds.

    Runs look for it five times a second, but not inside a sample, and a sample of strange dynamics may take minutes.
    """
    heard, tell = os.pipe()
    os.set_blocking(tell, False)
    signal.set_wakeup_fd(tell)

    def watch() -> None:
        while os.read(heard, 1) != bytes([signal.SIGINT]):
            pass
        time.sleep(patience)
        if not _told.is_set():
            abandon()
            _say_interrupted()
        os._exit(130)

    threading.Thread(target=watch, daemon=True).start()


def _drop_output() -> None:
    """Nobody takes it: what is still waiting must not be tried once more when Python ends."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context, version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False
) -> None:
    if version:
        typer.echo(_core.__version__)
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command("list")
def list_(
    family: Annotated[
        str | None, typer.Argument(help="A family of components, `scenario`, `campaign` or `paper`.")
    ] = None,
    as_json: Json = False,
) -> None:
    """List what there is: components by family, shipped scenarios and campaigns, papers.

    Examples: `gyrostat list`, `gyrostat list fault`, `gyrostat list controller --json`
    """
    from gyrostat import papers
    from gyrostat.campaign.catalogue import shipped as campaigns

    known = {**_core.catalogue(), "scenario": sorted(shipped()), "campaign": sorted(campaigns())}
    known["paper"] = papers.available()
    if family is not None:
        if family not in known:
            raise InputError(f"no family '{family}'{suggestion(family, known)}")
        known = {family: known[family]}
    if as_json:
        printing.as_json(known)
        return
    printing.names(known)


@app.command()
def describe(
    family: Annotated[str, typer.Argument(help="A family, or the name of a component.")],
    name: Annotated[str | None, typer.Argument(help="The component.")] = None,
    as_json: Json = False,
) -> None:
    """Show the parameters of a component: default, unit, range and meaning.

    Examples: `gyrostat describe observer finite_time_disturbance`, `gyrostat describe vehicle`
    """
    info = _core.describe(*_component(family, name))
    if as_json:
        printing.as_json(info)
        return
    printing.component(info)


@app.command()
def new(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="A new file.")],
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="That of a shipped scenario: `ftc_4rw`, `flexible_4`, ...; the beginning of a name is enough."
        ),
    ] = None,
    like: Annotated[
        str | None, typer.Option(help="All of a scenario instead: a shipped one (`gyrostat list scenario`), or a file.")
    ] = None,
) -> None:
    """Write a first scenario: a vehicle, the recommended stack, a fault, and comments that say what to change.

    Examples: `gyrostat new my.toml`, `gyrostat new cubesat.toml --vehicle cubesat`,
    `gyrostat new my.toml --like li2018/table2`
    """
    from gyrostat import first_scenario

    if file.suffix != ".toml":
        raise InputError(f"{file}: a scenario's file ends in .toml")
    if vehicle is not None and like is not None:
        raise InputError("--vehicle and --like: give one of them")
    vehicle = first_scenario.vehicle_called(vehicle or "ftc_4rw")
    text = first_scenario.first_scenario(vehicle) if like is None else first_scenario.like(like)
    if os.path.lexists(file):
        raise InputError(f"{file}: is there already, and is left as it is")
    with made_folder(file.parent):
        write_text(file, text)
    name = shlex.quote(str(file))
    typer.echo(f"{file}: {vehicle if like is None else f'as {like}'}; next:")
    typer.echo(f"  gyrostat run {name} --out flight    # fly it; flight/index.html re-plays it")
    typer.echo(f"  gyrostat check {name}               # what can be said before it flies")
    typer.echo(f"  gyrostat schema --install {name}    # your editor then completes and checks it")


@app.command()
def run(
    scenario: ScenarioName,
    settings: Settings = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Save: `run.npz` for the data, a folder for data, scenario, figure and a page (`index.html`)."
        ),
    ] = None,
    *,
    every: Annotated[int | None, typer.Option(min=1, help="Record every so many samples.")] = None,
    single_file: SingleFile = False,
    as_json: Json = False,
) -> None:
    """Fly a scenario and say how it went; `--out FOLDER` leaves a page that re-plays it.

    A run that ends early (singularity, non-finite state, failed integration) is saved up to there; exit status 3, and
    also where the stack never issued a command of its own.

    Examples: `gyrostat run wheel2_degraded`, `gyrostat run my.toml --set observer.lambda1=2 --out run.npz`
    """
    flown = _scenario(scenario, settings)
    with _target(out):
        with printing.progress(f"flying {scenario}") as progress:
            result = flown.run(channels=_recorded(flown, out), every=every, progress=progress)
        if out is not None:
            _save(result, out, single_file=single_file)
    if as_json:
        printing.as_json(
            {
                "scenario": scenario,
                "status": result.status,
                "cause": result.cause,
                "end_time": result.end_time,
                "samples": len(result),
                "metrics": result.metrics.to_dict(),
                "events": [vars(e) for e in result.events],
                "statistics": dict(result.statistics),
                "remarks": flown.remarks(),
                "out": None if out is None else str(out),
            }
        )
    else:
        printing.run(result, flown.remarks())
    if not result.completed:
        ended = "" if result.status == "no_command" else f"the run ended at {result.end_time:g} s: "
        raise typer.Exit(printing.complain(f"{ended}{result.cause or result.status}", 3))


@app.command()
def compare(
    names: Annotated[
        list[str], typer.Argument(metavar="RUN...", help="Scenarios, saved results (`run.npz`), or folders of `--out`.")
    ],
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=A,B,...", help="Fly one scenario with each of these values. Repeatable: all pairs."),
    ] = None,
    settings: Settings = None,
    *,
    out: Annotated[
        Path | None, typer.Option(help="A folder, or a file `.html`, for a page that lays the runs over each other.")
    ] = None,
    every: Annotated[int | None, typer.Option(min=1, help="Record every so many samples.")] = None,
    single_file: SingleFile = False,
    as_json: Json = False,
) -> None:
    """Fly several scenarios, or one with several values, and print their metrics beside each other.

    Runs that end early are compared up to there; exit status 3.

    Examples: `gyrostat compare wheel2_degraded --vary controller=mrp_feedback,integral_sliding_mode --out page`,
    `gyrostat compare before.npz after.npz`
    """
    from gyrostat import comparison, page

    with nullcontext() if out is None else made_folder(page.page_path(out).parent):
        with printing.progress(f"comparing {', '.join(names)}") as progress:
            runs = comparison.fly(_compared(names, vary, settings), every=every, progress=progress)
        written = None if out is None else page.write_page(out, runs, single_file=single_file)
    if as_json:
        rows = [
            {
                "run": label,
                "status": r.status,
                "cause": r.cause,
                "end_time": r.end_time,
                "metrics": r.metrics.to_dict(),
            }
            for label, r in runs.items()
        ]
        printing.as_json({"runs": rows, "out": None if written is None else str(written)})
    else:
        printing.columns(comparison.metric_rows(runs))
        if written is not None:
            typer.echo(f"page: {written}")
    early = {label: r for label, r in runs.items() if not r.completed}
    if early:
        label, result = next(iter(early.items()))
        raise typer.Exit(
            printing.complain(f"{label} ended at {result.end_time:g} s: {result.cause or result.status}", 3)
        )


def _compared(
    names: Sequence[str], vary: Sequence[str] | None, settings: Sequence[str] | None
) -> dict[str, Scenario | Result]:
    """What `compare` holds against each other, flown or to be flown."""
    from gyrostat import comparison

    changes = _changes(settings)
    runs = comparison.load(names)
    for label, run in runs.items():
        if (changes or vary) and not isinstance(run, Scenario):
            raise InputError(f"{label}: is a saved result; --set and --vary change scenarios")
    given = {k: r.replace(**changes) if changes and isinstance(r, Scenario) else r for k, r in runs.items()}
    if not vary:
        return given
    if len(given) != 1:
        raise InputError(f"--vary: takes one scenario, not {len(given)}")
    (only,) = given.values()
    assert isinstance(only, Scenario)  # refused above
    return dict(comparison.variants(only, dict(comparison.read_variation(text) for text in vary)))


@app.command()
def reproduce(
    paper: Annotated[str, typer.Argument(help="A paper (`gyrostat list paper`), the folder of one, or `all`.")],
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the report (`index.html`), its cases and figures; without it, claims only."),
    ] = None,
    *,
    data: Annotated[bool, typer.Option("--data", help="Save what figures draw, too, in full (`.npz`, 40 MB).")] = False,
    claim: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ID", help="Only this claim, e.g. `t1.settling_1e-3`, or those that fit `t1.*`. Repeatable."
        ),
    ] = None,
    verbose: Annotated[bool, typer.Option("--verbose", help="Print every claim also of `all`.")] = False,
    as_json: Json = False,
) -> None:
    """Fly every case of a paper and hold its claims against what is measured.

    Repeats over seeds are one line. With `all` it prints a line a paper, and what is not accepted. Exit status 1 if a
    claim is outside what we accept.

    Examples: `gyrostat reproduce li2018`, `gyrostat reproduce li2018 --claim 't1.settling*'`,
    `gyrostat reproduce all --out report`
    """
    from gyrostat import papers

    chosen = [papers.load(name) for name in (papers.available() if paper == "all" else [paper])]
    if claim:
        if out is not None:
            raise InputError("--claim: prints its claims; a report (--out) holds all of them")
        chosen = _with_claims(chosen, claim)
    briefly = paper == "all" and not (verbose or as_json)
    found, page = _reproduced(chosen, out, briefly=briefly, with_data=data)
    failed = sum(r.failed for r in found)
    if as_json:
        parts = [r.to_dict() for r in found]
        total = {"papers": parts, "passed": sum(p["passed"] for p in parts), "failed": failed}
        printing.as_json(total if paper == "all" else parts[0])
    else:
        printing.reproductions(found, page, briefly=briefly)
    if failed:
        raise typer.Exit(1)


def _reproduced(
    studies: Sequence[Paper], out: Path | None, *, briefly: bool, with_data: bool
) -> tuple[list[Reproduction], Path | None]:
    """What was found, and the report if one is wanted."""
    from gyrostat import papers

    found: list[Reproduction] = []

    def fly(one: Paper) -> Reproduction:
        """Results are kept where figures are drawn, and then for one study at a time."""
        with printing.progress(f"reproducing {one.id}") as progress:
            flown = papers.reproduce(one if out is not None else replace(one, figures=()), progress=progress)
        found.append(flown.without_results())
        if briefly:
            printing.tally(flown)
        return flown

    if out is None:
        for one in studies:
            fly(one)
        return found, None
    with made_folder(out):
        from gyrostat.report import write_report

        return found, write_report(out, map(fly, studies), with_data=with_data)


def _with_claims(studies: Sequence[Paper], patterns: Sequence[str]) -> list[Paper]:
    """Studies with the claims that fit any of the patterns; those that have none are left out."""
    kept = [(one, [c for c in one.claims if any(c.fits(p) for p in patterns)]) for one in studies]
    some = [one.only(claims) for one, claims in kept if claims]
    if not some:
        known = {c.id for one in studies for c in one.claims}
        raise InputError(f"no claim '{patterns[0]}'{suggestion(patterns[0], known)}")
    return some


@app.command()
def check(
    scenario: ScenarioName,
    settings: Settings = None,
    *,
    effectiveness: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="LOW HIGH", help="Range to hold the loop against, instead of the faults' own."),
    ] = None,
    torque: Annotated[
        tuple[float, float, float] | None,
        typer.Option(metavar="X Y Z", help="A demand, N m in the body frame, that must be within reach."),
    ] = None,
    fly: Annotated[
        bool, typer.Option("--fly", help="Fly it too, and say how often its demand is out of the actuators' reach.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FOLDER", help="For a page: torques within reach, margins, figures.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Check a scenario without flying it: components against vehicle and period, stability, torque within reach.

    With a learning disturbance observer it gives the exact conditions of stability, for every delay and as sampled,
    and what the published theorem admits. With mixed learning it gives the margin of every condition of its
    theorems and the exact stability of the sampled loop. With a finite-time disturbance observer it says whether
    feeding the estimate forward through weakened actuators is stable, unstable or unproven, with the critical
    effectiveness. With any observer that estimates something it says who uses the estimate, between which
    effectiveness of the actuators the sampled loop is stable, measured by small flights of the stack, and whether
    it is with what the faults leave. With an observer of effectiveness it says what cannot be identified. It also
    says which torque the actuators can give in every direction, healthy and when the faults leave them least.
    `--out` leaves a page (`index.html`) that draws these torques, the margins as bars, and frequency response and
    stable gains where there are any. Exit status 1 if a check fails.

    Examples: `gyrostat check wheel2_degraded --torque 0.1 0.2 0`, `gyrostat check li2018/table2 --effectiveness 0.05 1`
    """
    from gyrostat import design

    for option, numbers in (("--effectiveness", effectiveness), ("--torque", torque)):
        if numbers is not None and not all(math.isfinite(x) for x in numbers):
            raise InputError(f"{option} {' '.join(map(str, numbers))}: finite numbers belong here")
    if effectiveness is not None and effectiveness[0] > effectiveness[1]:
        raise InputError(f"--effectiveness {effectiveness[0]:g} {effectiveness[1]:g}: the lower end comes first")
    checked = _scenario(scenario, settings)
    rows = checked.check()
    findings = design.findings(checked, effectiveness=effectiveness, torque_B=torque, fly=fly)
    page = None if out is None else _drawn(checked, rows, findings, out, torque)
    if as_json:
        printing.as_json({"checks": rows, "design": [vars(f) for f in findings], "remarks": checked.remarks()})
    else:
        printing.checks(rows, checked.remarks(), findings)
        if page is not None:
            typer.echo(f"page: {page}")
    if not all(r["ok"] for r in rows) or any(f.ok is False for f in findings):
        raise typer.Exit(1)


def _drawn(
    scenario: Scenario, rows: list[dict[str, Any]], findings: list[Finding], out: Path, torque_B: Sequence[float] | None
) -> Path:
    """The page of `gyrostat check --out`, with its figures as pictures and data beside it."""
    from gyrostat import design
    from gyrostat.page import page_path
    from gyrostat.page.check import write_check_page

    target = page_path(out)
    figures = {name: figure for draw in design.FIGURES for name, figure in draw(scenario).items()}
    with made_folder(target.parent):
        _save_figures(figures, target.parent)
        return write_check_page(target, scenario, rows, findings, figures, torque_B=torque_B)


def _save_figures(figures: Mapping[str, Figure], out: Path) -> None:
    """Pictures with their data beside them, by name."""
    with made_folder(out) as folder:
        for name, figure in figures.items():
            figure.save(folder / f"{name}.png")


@app.command()
def design(
    name: Annotated[str | None, typer.Argument(help="A design; without one they are listed.")] = None,
    scenario: Annotated[
        str | None, typer.Argument(help="A scenario that gives the vehicle and the period; `--set` wins.")
    ] = None,
    more: Annotated[
        list[str] | None, typer.Argument(metavar="KEY=VALUE", help="Options of the design, as after `--set`.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="An option of the design, e.g. `settling_time=2`. Repeatable."),
    ] = None,
    *,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FOLDER", help="For pictures of what was designed.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Design gains: parameters that can be pasted into a scenario, with every condition and its margin.

    By its name each controller gets gains for a bandwidth (rad/s) and a damping, with phase, gain and delay margin of
    the sampled loop, what appendages that bend do to it, and what a step asks of the actuators. Without a name it lists
    the designs, with their options. Exit status 1 if a condition fails or no gains exist.

    Examples: `gyrostat design`, `gyrostat design mrp_feedback flexible_4 --set bandwidth=0.1 damping=0.8`,
    `gyrostat design mixed_learning ftc_4rw --set settling_time=5`
    """
    from gyrostat.design import DESIGNS
    from gyrostat.design.bandwidth_rules import WITHOUT_RULE

    if name is None:
        if as_json:
            printing.as_json({key: d.summary for key, d in DESIGNS.items()})
            return
        printing.designs(DESIGNS)
        return
    if name in WITHOUT_RULE:
        raise InputError(f"no design '{name}': {WITHOUT_RULE[name]}")
    if name not in DESIGNS:
        raise InputError(f"no design '{name}'{suggestion(name, DESIGNS)}")
    chosen = DESIGNS[name]
    wanted = [*(settings or ()), *(more or ())]
    given: dict[str, Any] = {}
    if scenario is not None and "=" in scenario and not Path(scenario).exists():  # an option: there is no vehicle
        wanted.append(scenario)
    elif scenario is not None:
        given = chosen.of_scenario(Scenario.load(scenario))
    report = chosen.run(chosen.options(**(given | _changes(wanted))))
    if out is not None:
        _save_figures(report.figures(), out)
    if as_json:
        printing.as_json(report.to_dict())
    else:
        printing.design(report)
    if not report.ok:
        raise typer.Exit(1)


@app.command()
def export(
    scenario: ScenarioName,
    target: Annotated[
        str, typer.Option(help="`cpp`: a header. `c`: a C library. `fmu`: an FMI 2.0 co-simulation unit.")
    ],
    out: Annotated[Path, typer.Option(help="A new or empty folder; it appears when it is complete.")],
    settings: Settings = None,
    *,
    scalar: Annotated[str, typer.Option(help="`double` or `float`: of the C library and the self-test.")] = "double",
    samples: Annotated[int, typer.Option(min=0, help="Recorded samples, from the first on; 0: the whole run.")] = 3000,
    name: Annotated[str | None, typer.Option(help="Of files and functions, instead of the scenario's.")] = None,
) -> None:
    """Write the flight stack of a scenario as code, with a self-test of recorded inputs and outputs.

    The folder holds vehicle, components and parameters of the scenario, and every header that it needs but Eigen's.

    Examples: `gyrostat export wheel2_degraded --target c --out code`, `gyrostat export my.toml --target fmu --out fmu`
    """
    from gyrostat.export import export as write_code

    chosen = _scenario(scenario, settings)
    code = write_code(chosen, target, out, scalar=scalar, samples=samples, name=name)
    if target == "fmu":
        typer.echo(f"{out / code.name}.fmu: {len(code.rows)} recorded samples beside it")
        return
    typer.echo(f"{out}: {len(code.rows)} recorded samples; build and test it:")
    folder, build = shlex.quote(str(out)), shlex.quote(f"{out}/build")
    typer.echo(f"  cmake -S {folder} -B {build} && cmake --build {build} && ctest --test-dir {build}")


@app.command()
def config(
    include: Annotated[bool, typer.Option("--include", help="The folder of the headers alone.")] = False,
    cmake: Annotated[bool, typer.Option("--cmake", help="The folder for `-Dgyrostat_DIR` alone.")] = False,
) -> None:
    """Say where this package holds the headers of the flight library; they need Eigen 3.4 and nothing else.

    Examples: `cmake -B build -Dgyrostat_DIR=$(gyrostat config --cmake)`, `c++ -I$(gyrostat config --include) ...`
    """
    package = Path(__file__).absolute().parent
    folders = {"include": package / "include", "cmake": package / "cmake"}
    wanted = [name for name, asked in (("include", include), ("cmake", cmake)) if asked]
    for name in wanted or folders:
        if not folders[name].is_dir():
            raise InputError(f"{folders[name]}: not part of this installation; a package that pip installed has it")
    if wanted:
        for name in wanted:
            typer.echo(folders[name])
    else:
        printing.columns([("version", _core.__version__), *((name, str(folder)) for name, folder in folders.items())])


@app.command()
def schema(
    out: Annotated[Path | None, typer.Option(help="Write to a file.")] = None,
    install: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.toml", help="Write it beside a scenario, and into that the line by which editors find it."
        ),
    ] = None,
) -> None:
    """Print the JSON Schema of the scenario file; editors check and complete TOML with it.

    Examples: `gyrostat schema --out scenario.schema.json`, `gyrostat schema --install my.toml`
    """
    from gyrostat.schema import install_schema, schema_text

    if install is not None:
        if out is not None:
            raise InputError("--out and --install: give one of them")
        typer.echo(f"{install_schema(install)}: {install} names it in its first line")
        return
    text = schema_text()
    if out is None:
        typer.echo(text, nl=False)
        return
    with made_folder(out.parent):
        write_text(out, text)


@app.command()
def completion(
    shell: Annotated[str, typer.Argument(help="`bash`, `zsh` or `fish`.")],
    line: Annotated[str | None, typer.Option(hidden=True)] = None,
) -> None:
    """Print what makes a shell complete commands, scenarios, components, and keys of `--set`.

    Examples: `eval "$(gyrostat completion bash)"`, `gyrostat completion fish | source`
    """
    from gyrostat import completion as shells

    if line is None:
        typer.echo(shells.script(shell), nl=False)
        return
    with suppress(InputError):  # of a scenario that is being written, say
        for found in shells.answer(typer.main.get_command(app), shell, line):
            typer.echo(found)


app.add_typer(cli_campaign.app, name="campaign")
app.add_typer(cli_dataset.app, name="dataset")
app.command()(cli_campaign.report)
cli_verification.register(app)
cli_survival.register(app)


def _scenario(name: str, settings: Sequence[str] | None) -> Scenario:
    scenario = Scenario.load(name)
    changes = _changes(settings)
    return scenario.replace(**changes) if changes else scenario


def _changes(settings: Sequence[str] | None) -> dict[str, Any]:
    """Values of `--set`, by key."""
    changes = {}
    for given in settings or ():
        setting = unescaped(given)
        key, equals, text = setting.partition("=")
        if not equals or not key.strip():
            raise InputError(f"--set {setting}: write KEY=VALUE, for example --set observer.lambda1=2")
        changes[key.strip()] = toml.value(text.strip())
    return changes


def _component(family: str, name: str | None) -> tuple[str, str]:
    """Family and name of what is to be described; a name alone suffices when only one family has it."""
    catalogue = _core.catalogue()
    family, name = current(family), None if name is None else current(name)
    if name is not None:
        if family not in catalogue:
            raise InputError(f"no family '{family}'{suggestion(family, catalogue)}")
        if name not in catalogue[family]:
            raise InputError(f"no {family} '{name}'{suggestion(name, catalogue[family])}")
        return family, name
    if len(catalogue.get(family, ())) == 1:
        return family, catalogue[family][0]
    if family in catalogue:
        raise InputError(f"which {family}? there are: {', '.join(catalogue[family])}")
    owners = [f for f, names in catalogue.items() if family in names]
    if not owners:
        every = {n for names in catalogue.values() for n in names} | set(catalogue)
        raise InputError(f"no component '{family}'{suggestion(family, every)}")
    if len(owners) > 1:
        raise InputError(f"'{family}' is in several families: {', '.join(owners)}; name one first")
    return owners[0], family


@contextmanager
def _target(out: Path | None) -> Iterator[None]:
    """Say before a run that its result could not be written, and leave no empty folder when it is not."""
    if out is None:
        yield
        return
    if out.suffix not in ("", ".npz"):
        raise InputError(f"--out {out}: a file ends in .npz; a name without ending is a folder")
    checked_target(out if out.suffix else out / "overview.npz")
    if not out.suffix:
        from gyrostat.page import page_path

        page_path(out)
    with made_folder(out.parent if out.suffix else out):
        yield


def _recorded(scenario: Scenario, out: Path | None) -> list[str] | None:
    """Channels of a run; a folder gets a page, which shows more than is usually recorded."""
    if out is None or out.suffix:
        return None
    from gyrostat.page import channels

    return channels(scenario)


def _save(result: Result, out: Path, *, single_file: bool) -> None:
    if out.suffix:
        result.save(out)
        return
    result.save(out / "result.npz")
    if isinstance(result.scenario, Scenario):
        result.scenario.to_toml(out / "scenario.toml")
    if len(result) > 1:
        result.plot().save(out / "overview.png")
    result.to_html(out, single_file=single_file)


__all__ = ["app", "main"]
