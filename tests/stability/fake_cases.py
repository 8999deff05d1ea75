"""Cases that hold, fail, crash, print or never end, without a simulation; the children of the suite import them from here."""

from __future__ import annotations

import os
import signal
import time

from mpmkit.errors import CompositionError, StabilityError
from mpmkit.stability import Case, Figure


def holds(composition, quick):
    print("a component may print")
    return [Figure("error", 0.5, 1.0), Figure("nothing", 0.0, 0.0)]


def bounded(composition, quick):
    return [Figure("error", -2.0, 1.0)]


def guard(composition, quick):
    raise StabilityError("particle 3 of body 'a': J = -1 <= 0")


def refused(composition, quick):
    raise CompositionError("these do not fit")


def broken(composition, quick):
    raise ZeroDivisionError("division by zero")


def crash(composition, quick):
    os.kill(os.getpid(), signal.SIGSEGV)


def leaves(composition, quick):
    os._exit(7)


def never(composition, quick):
    time.sleep(3600.0)


def process(composition, quick):
    return [Figure("process", float(os.getpid()), 0.0)]


def nan(composition, quick):
    return [Figure("error", float("nan"), 1.0)]


def case(measure, **more):
    return Case(measure.__name__, measure.__name__, "why", "what", "whence", 1, measure, **more)


WAITING = case(holds, waits_for="a shock equation of state")


def stopped(composition, quick):
    raise StabilityError("energy was created\nlast good state: step 81, t = 1.5 s, /some/folder/run.ckpt.h5")
