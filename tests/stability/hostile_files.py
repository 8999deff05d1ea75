"""Scene files as nobody should write them: good scenes, changed at random in their text, their structure and their values."""

from __future__ import annotations

import copy
import datetime as dt
import json
import random
from pathlib import Path
from typing import Any

import tomli_w

from mpmkit._core.registry import registry
from mpmkit.geometry import GEOMETRIES
from mpmkit.parameters import example_arguments, specs

EXAMPLES = Path(__file__).parents[2] / "examples"

NUMBERS: tuple[Any, ...] = (
    0, -1, 1, 2, 3, 7, -0.0, 0.5, -1e-9, 1e-9, 1e-30, 5e-324, 1e30, -1e30, 1.7e308, -1.7e308, float("inf"), float("-inf"), float("nan"),
    2**31, 2**63 - 1, -(2**63), 2**64, 10**40, 10**400, True, False,
)  # fmt: skip
FORMULAS = (
    "__import__('os').system('touch /hacked')", "().__class__.__bases__[0].__subclasses__()", "9**9**9**9", "exec('1')", "open('/etc/passwd')",
    "x.__class__", "lambda: 0", "[x for x in (1,)]", "x if y else z", "1/0", "0/0", "log(-1)", "sqrt(-x)", "exp(1000)", "x**64**64", "x**-64",
    "1e999", "-1e999", "nan", "inf", "min(x)", "max()", "sin", "sin()", "sin(x, y)", "x = 1", "x;y", "x\ny", "(" * 90 + "x" + ")" * 90,
    "-" * 500 + "x", "x" + "+x" * 480, "x" * 2000, "t", "X*Y", "vx", "2 if x < 1 else 1e400", "x < y", "not x", "1_000", "0x10", "1j", "'a'", "b'a'",
    "f'{x}'", "x@y", "x//y", "x%y", "x^2", "x and y", "(x := 1)", "*x", "...", "True", "None", "x is y", "await x", "yield",
)  # fmt: skip
TEXTS = (
    "", " ", "\n", "\0", "\ud7ff", "é", "ｍ", "🧨", "\u202eevil", "a" * 10_000, "../../etc/passwd", "/", ".", "CON", "all", "xmin", "zmax", "__class__",
    "1 mm", "1 furlong", "1e400 m", "-1 kg", "nan m", "inf s", "1 m/s/s/s", "9**9**9 m", "1 m**99999999", "2.5 degC", "1 %", "1 mm mm mm",
    "1" * 400 + " m", "steel", "Box", "Gravity", "FLIP", "{{}}", "%s%n", "${HOME}", "{0.__class__}", *FORMULAS,
)  # fmt: skip
KEYS = (
    "kind",
    "E",
    "nu",
    "x",
    "",
    " ",
    "__class__",
    "__init__",
    "a.b",
    "é",
    "\0",
    "k" * 5000,
    "until",
    "grid",
    "materials",
    "self",
    "cls",
    "lower",
)
JUNK = (
    "\0",
    "\x7f",
    "\ufeff",
    "[",
    "]",
    "{",
    "}",
    "=",
    '"',
    "'",
    '"""',
    "#",
    "\\",
    "\\u0000",
    "\\uD800",
    "[[",
    "]]",
    ",",
    "1e",
    "0x",
    "inf",
    "\r",
    "\u2028",
)


def seeds() -> list[dict[str, Any]]:
    """Good scenes as data: those of the examples, and between them every component of the registry and every shape."""
    import tomllib

    found = [tomllib.loads(p.read_text(encoding="utf-8")) for p in sorted(EXAMPLES.glob("*.toml"))]
    plain = {
        "grid": {"lower": [0.0, 0.0], "upper": [2.0, 2.0], "spacing": 0.25},
        "shape": {"kind": "QuadraticBSpline"},
        "integrator": {"kind": "MUSL"},
        "materials": {"soft": {"kind": "NeoHookean", "E": "1 kPa", "nu": 0.3, "rho": 1000.0}},
        "bodies": [
            {"name": "bar", "geometry": {"kind": "Box", "lower": [0.5, 0.5], "upper": [1.0, 1.0]}, "material": "soft", "v": ["x", "0"]}
        ],
    }
    for entry in registry().entries:
        scene = copy.deepcopy(plain)
        arguments = {k: _listed(v) for k, v in example_arguments(entry.component).items()}
        table = {"kind": entry.name} | {k: (v * 2)[:2] if isinstance(v, list) else v for k, v in arguments.items()}
        match entry.kind:
            case "shape" | "integrator":
                scene[entry.kind] = table
            case "transfer":
                scene["integrator"]["transfer"] = table
            case "material":
                scene["bodies"][0]["material"] = table
            case "boundary":
                scene["boundaries"] = [
                    table | {name: "xmax" if name == "face" else ["xmax"] for name in ("face", "faces") if name in specs(entry.component)}
                ]
            case "contact":
                scene["contacts"] = [table]
            case "effect":
                scene["effects"] = [table]
            case "discretization":
                del scene["shape"], scene["integrator"]
                scene["discretization"] = table
        found.append(scene)
    for cls in GEOMETRIES.values():
        scene = copy.deepcopy(plain)
        body = scene["bodies"][0]
        body["geometry"] = geometry(cls(**example_arguments(cls)))
        if cls.__name__ in ("Sphere", "Cylinder"):
            scene["grid"] = {"lower": [0.0] * 3, "upper": [2.0] * 3, "spacing": 0.25}
            body["v"] = 0.0
        found.append(scene)
    return found


def geometry(shape: Any) -> dict[str, Any]:
    """A shape as the table of a scene file."""
    import attrs

    table: dict[str, Any] = {"kind": type(shape).__name__}
    for field in attrs.fields(type(shape)):
        value = getattr(shape, field.name)
        if value is not None:
            table[field.name] = _listed(value)
    return table


def _listed(value: Any) -> Any:
    if isinstance(value, (tuple, list)):
        return [_listed(v) for v in value]
    return geometry(value) if type(value).__name__ in GEOMETRIES else value


# --- structure and values -----------------------------------------------------------------------------------------
def places(data: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) inside the data."""
    found: list[tuple[Any, Any]] = []
    stack = [data]
    while stack:
        here = stack.pop()
        for key, value in here.items() if isinstance(here, dict) else enumerate(here):
            found.append((here, key))
            if isinstance(value, (dict, list)):
                stack.append(value)
    return found


def odd_value(rng: random.Random) -> Any:
    """A value that hardly any key expects."""
    choice = rng.randrange(9)
    if choice < 3:
        return rng.choice(NUMBERS)
    if choice < 5:
        return rng.choice(TEXTS)
    if choice == 5:
        return nested(rng.choice((1, 3, 30, 150)), rng.choice((1.0, "x", {})), rng)
    if choice == 6:
        return [rng.choice(NUMBERS) for _ in range(rng.choice((0, 1, 2, 3, 4, 9, 3000)))]
    if choice == 7:
        return rng.choice((dt.datetime(2000, 1, 1), dt.date(2000, 1, 1), dt.time(1, 2), {}, [], [[]], [{}]))
    return {"kind": rng.choice([e.name for e in registry().entries] + list(GEOMETRIES))}


def nested(depth: int, value: Any, rng: random.Random) -> Any:
    """A value inside many arrays, tables, or shapes."""
    kind = rng.randrange(4)
    for _ in range(depth):
        value = ([value], {"a": value}, {"kind": "Transformed", "shape": value, "scale": 0.999}, {"kind": "Union", "shapes": [value]})[kind]
    return value


def mutate(data: dict[str, Any], rng: random.Random) -> dict[str, Any]:
    """A copy with a few random changes."""
    data = copy.deepcopy(data)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        found = places(data)
        if not found:
            return data
        here, key = rng.choice(found)
        other, second = rng.choice(found)
        choice = rng.randrange(10)
        if choice == 0:
            del here[key]
        elif choice == 1 and isinstance(here, list):
            here.extend(copy.deepcopy(here[key]) for _ in range(rng.choice((1, 2, 50))))
        elif choice == 2 and isinstance(here, dict):
            here[typo(key, rng)] = here.pop(key)
        elif choice == 3 and isinstance(here, dict):
            here[rng.choice(KEYS)] = odd_value(rng)
        elif choice == 4:
            value = copy.deepcopy(other[second])
            other[second], here[key] = copy.deepcopy(here[key]), value
        elif choice == 5 and isinstance(here[key], (int, float)) and not isinstance(here[key], bool):
            here[key] = _times(here[key], rng.choice((-1, 0, 1e-12, 1e-3, 1.0000001, 1e3, 1e12, 1e300)))
        elif choice == 6 and isinstance(here[key], (dict, list)):
            here[key] = nested(rng.choice((1, 5, 100)), here[key], rng)
        else:
            here[key] = odd_value(rng)
    return data


def believable(data: dict[str, Any], rng: random.Random) -> dict[str, Any]:
    """A copy in which only numbers have changed, or a kind into another one: most of them are read, and must then compose or not."""
    data = copy.deepcopy(data)
    for _ in range(rng.choice((1, 1, 2, 4))):
        numbers = [(h, k) for h, k in places(data) if isinstance(h[k], (int, float)) and not isinstance(h[k], bool)]
        kinds = [(h, k) for h, k in places(data) if k == "kind"]
        if kinds and rng.random() < 0.2:
            here, key = rng.choice(kinds)
            here[key] = rng.choice([e.name for e in registry().entries] + list(GEOMETRIES))
        elif numbers:
            here, key = rng.choice(numbers)
            factor = rng.choice((-1, 0, 1e-12, 1e-3, 0.1, 0.5, 0.9, 1.0 - 1e-12, 1.0 + 1e-7, 1.5, 2, 3, 10, 1e3, 1e12, 1e160, 1e300))
            here[key] = rng.choice(NUMBERS) if rng.random() < 0.2 else _times(here[key], factor)
    return data


def _times(number: float, factor: float) -> float:
    return number * factor if abs(number) < 1e300 else -number


def typo(key: Any, rng: random.Random) -> str:
    """Nearly the same name."""
    text = str(key)
    at = rng.randrange(len(text) + 1)
    return rng.choice(
        (text[:at] + text[at + 1 :], text[:at] + rng.choice("xé_ .\0") + text[at:], text.upper(), text[::-1], rng.choice(KEYS))
    )


def cyclic_names(rng: random.Random) -> dict[str, Any]:
    """Materials and bodies that refer to each other by name."""
    names = rng.sample(["a", "b", "c", "soft"], 3)
    scene = copy.deepcopy(rng.choice(seeds()))
    scene["materials"] = {names[k]: rng.choice((names[k - 1], {"kind": names[k - 1]}, [names[k - 1]])) for k in range(3)}
    for body in scene.get("bodies", []):
        body["material"] = rng.choice(names)
        body["name"] = rng.choice(names)
    return scene


# --- text ---------------------------------------------------------------------------------------------------------
def as_text(data: dict[str, Any], rng: random.Random) -> tuple[str, str]:
    """The data as TOML or JSON, and which; JSON where TOML has no word for something."""
    try:
        if rng.random() < 0.8:
            return tomli_w.dumps(data), "toml"
    except (TypeError, ValueError, RecursionError, AttributeError):
        pass
    return json.dumps(data, default=str), "json"


def spoil(text: str, rng: random.Random) -> str:
    """The text with something that a slip of the hand, a bad copy or malice may do to it."""
    for _ in range(rng.choice((1, 1, 2, 5))):
        at = rng.randrange(len(text) + 1)
        lines = text.split("\n")
        k = rng.randrange(len(lines))
        choice = rng.randrange(9)
        if choice == 0:
            text = text[:at]
        elif choice == 1:
            text = text[:at] + rng.choice(JUNK) + text[at:]
        elif choice == 2:
            text = text[:at] + text[at + 1 :]
        elif choice == 3:
            text = "\n".join([*lines[:k], lines[k], *lines[k:]])
        elif choice == 4:
            text = "\n".join(lines[:k] + lines[k + 1 :])
        elif choice == 5:
            j = rng.randrange(len(lines))
            lines[k], lines[j] = lines[j], lines[k]
            text = "\n".join(lines)
        elif choice == 6:
            deep = rng.choice((50, 900, 5000))
            text += rng.choice(
                (
                    f"\nz = {'[' * deep}",
                    f"\nz = {'[' * deep}{']' * deep}",
                    "\n[" + ".".join(["z"] * deep) + "]\n",
                    f"\nz = {'{a=' * deep}1{'}' * deep}",
                    f"\nz = {'9' * deep}",
                )
            )
        elif choice == 7:
            text = text[:at] + rng.choice(TEXTS) + text[at:]
        else:
            text = text[:at] + "".join(chr(rng.randrange(1, 0x2FF)) for _ in range(rng.choice((1, 5, 200)))) + text[at:]
    return text


def spoil_bytes(raw: bytes, rng: random.Random) -> bytes:
    """The same for bytes."""
    changed = bytearray(raw)
    for _ in range(rng.choice((1, 3, 30))):
        if changed:
            changed[rng.randrange(len(changed))] = rng.randrange(256)
    return rng.choice(
        (
            bytes(changed),
            raw[: rng.randrange(len(raw) + 1)],
            raw + rng.randbytes(64),
            raw.decode("utf-8", "replace").encode("utf-16"),
            rng.randbytes(300),
        )
    )


def hostile(rng: random.Random, known: list[dict[str, Any]]) -> tuple[bytes, str]:
    """One scene file: its bytes, and "toml" or "json"."""
    data = rng.choice(known)
    choice = rng.randrange(10)
    if choice == 0:
        data = cyclic_names(rng)
    elif choice < 5:
        data = believable(data, rng)
    elif choice < 8:
        data = mutate(data, rng)
    text, form = as_text(data, rng)
    if choice >= 7:
        text = spoil(text, rng)
    raw = text.encode("utf-8", "surrogatepass")
    return (spoil_bytes(raw, rng) if choice == 9 else raw), form
