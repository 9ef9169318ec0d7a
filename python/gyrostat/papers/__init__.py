# SPDX-License-Identifier: MIT
"""Published studies as data: scenarios, claims and figures; `reproduce` flies the cases and evaluates the claims.

How to add a study
------------------
A study is a folder ``papers/<id>/`` (with an empty ``__init__.py``) that holds

``scenarios/<name>.toml``
    Its experiments. Parameters of the publication belong here, never into a component's defaults.
``claims.toml``
    What it claims and what we accept::

        title = "..."
        citation = "..., journal, year, doi"
        record = ["truth.mrp", "allocation.u", "observer.z1"]   # what claims and figures read

        [cases.table1]                       # scenarios/table1.toml
        [cases.table1_10ms]
        title = "Table 1 at 10 ms"
        scenario = "table1"                  # another case of the same scenario, with values changed
        set = { dt = 0.01, "controller.k1" = 4.9 }
        seeds = [2, 3]                       # and the cases table1_10ms_2 and _3, "Table 1 at 10 ms, seed 2" and 3
        [cases.table1_10ms_cvode]
        like = "table1_10ms"                 # an earlier case with its changes, and more of them
        set = { integrator = "cvode" }
        keep = ["truth", "allocation"]       # of the record these groups only; said where it saves much memory

        [[claims]]
        measure = { metric = "settling_time", signal = "truth.mrp" }
        quantity = "settling time of the MRP, s"
        rows = [
          { id = "t1.to_1e-3", case = "table1", band = 1e-3, published = 50, reported = [0, 50], accept = [42, 46] },
          { id = "t1.to_1e-4", case = ["table1", "table1_10ms"], band = 1e-4, accept = [63, "inf"], note = "..." },
        ]

    A case keeps what it offers of ``record``: one without an observer has no ``observer.z1``. A scenario that names
    channels of its own keeps those. ``keep`` holds for the cases that are like this one, too.

    A ``[[claims]]`` table is a measurement, and each of its rows a claim. A row takes what it does not say itself from
    the table; a table without rows is a claim by itself. The keys of a claim:

    ``id``, ``case``
        A list of cases gives a claim for each, ``<id>@<case>``.
    ``quantity``, ``note``
        What is measured, with its unit; what a reader should know (may be absent).
    ``published``
        Number or text of the publication. Absent: it gives none.
    ``reported``
        The measured values for which the publication's statement holds. ``"-inf"`` and ``"inf"`` are open ends.
    ``accept``
        What this library must measure.

    ``ok`` says whether the measured value lies in ``accept``, the verdict whether it lies in ``reported``: a claim can
    be ok and still show that a publication's statement does not hold. `metric` names an entry of `METRICS` (or of the
    study's own), the other keys of ``measure``, and those of a row that are no key of a claim, are its arguments.
    `signal` is a channel or one of the study's signals; ``column = 2`` picks a component. The size of a signal is its
    largest component, unless the metric says otherwise.
    ``[story]`` says what was ``promised``, what is ``seen`` here and ``why``; each of ``[[findings]]`` has a
    ``title``, a ``text`` and the ``claim`` to read on, the most surprising one first. ``{id}`` in them is the measured
    number of a claim: none is written by hand.
    ``[campaigns.<id>]`` tables fly one case many times with drawn changes: `gyrostat.papers.campaigns`.
``signals.py`` (may be absent)
    ``SIGNALS: dict[str, Callable[[Result], ndarray]]``, quantities computed from channels, one row a sample; and
    ``METRICS: dict[str, Callable[..., float]]``, called with the result and the keyword arguments of ``measure``.
``figures.py`` (may be absent)
    ``FIGURES: list[PaperFigure]``: name, caption, the cases it needs, and a function of the results (by case) that
    draws a `gyrostat.plots.Figure`. Its data are saved beside the picture. An `EnsembleFigure` draws campaigns.
"""

from __future__ import annotations

from gyrostat.papers.campaigns import CampaignCase, Ensemble
from gyrostat.papers.claims import Claim, Evaluation
from gyrostat.papers.folding import ExperimentRows, Row, Tally, folded
from gyrostat.papers.reproduction import Reproduction, reproduce
from gyrostat.papers.study import Case, EnsembleFigure, Paper, PaperFigure, available, load

__all__ = [
    "CampaignCase",
    "Case",
    "Claim",
    "Ensemble",
    "EnsembleFigure",
    "Evaluation",
    "ExperimentRows",
    "Paper",
    "PaperFigure",
    "Reproduction",
    "Row",
    "Tally",
    "available",
    "folded",
    "load",
    "reproduce",
]
