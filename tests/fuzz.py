"""Hostile inputs by the hundred: each ends with exit code 0, 1 or 2 and one line, in time.

python3 tests/fuzz.py           every key with 20 values, meshes cut and flipped at 200 places,
                                100 damaged branch.h5: about 10 minutes
python3 tests/fuzz.py --few     a small part of it, as the tests run it
python3 tests/fuzz.py --only loads      one of its parts: studies, loads, meshes, branches
python3 tests/fuzz.py --shard 1/2       every second input, for two processes at a time
"""

from __future__ import annotations

import argparse
import copy
import json
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path
from typing import Any, TextIO

from conftest import BEAM, PLATE, ROD, toml
from loaded_studies import CAMPBELL, FILES, LOADED, NEW, WARM

from fenics_nnm.processes import environment_of_child

#: Seconds and GiB of addresses that one input may take; the libraries take some before it comes.
SECONDS, GIBIBYTES = 60.0, 6.0

#: Values that keys are given: wrong types, extremes, long, deep, strange.
HOSTILE: tuple[Any, ...] = (
    *(0, -1, 1e300, 1e-300, -1e300, float("nan"), float("inf"), 10**30, 2**63, True),
    *("", "\\$\\frac{a", "x" * 100_000, "../../etc/passwd", "auto", "\u202e\u0001\U0001f600"),
    *([], [0.1] * 10_000, [[[[]]]], {"a": {"b": [1, {"c": 2}]}}),
)


@dataclass(frozen=True, slots=True)
class Input:
    """One input.

    Attributes:
        name: What it is.
        files: Bytes of its files by name.
        arguments: What fenics-nnm is called with.
    """

    name: str
    files: dict[str, bytes]
    arguments: tuple[str, ...]


Place = tuple[str | int, ...]


def leaves(values: Any, place: Place = ()) -> Iterator[Place]:
    """Places of the keys of a study, sections too, also those that come several times."""
    items = values.items() if isinstance(values, dict) else enumerate(values)
    for key, value in items:
        yield (*place, key)
        sections = isinstance(value, list) and value and isinstance(value[0], dict)
        if isinstance(value, dict) or sections:
            yield from leaves(value, (*place, key))


def with_value(base: dict[str, Any], place: Place, value: Any) -> dict[str, Any]:
    """A copy of a study with another value at a place."""
    study = copy.deepcopy(base)
    section: Any = study
    for key in place[:-1]:
        section = section[key]
    section[place[-1]] = value
    return study


def of_keys(
    name: str,
    base: dict[str, Any],
    places: list[Place],
    rng: random.Random,
    few: bool,
    files: dict[str, bytes],
) -> Iterator[Input]:
    """Each of the keys of a study with each hostile value."""
    for place in rng.sample(places, min(3, len(places))) if few else places:
        for value in rng.sample(HOSTILE, 2) if few else HOSTILE:
            said = f"{name} {'.'.join(map(str, place))} = {str(value)[:30]}"
            text = text_of(with_value(base, place, value))
            yield Input(said, {"s.toml": text, **files}, ("check", "s.toml"))


def of_studies(rng: random.Random, few: bool) -> Iterator[Input]:
    """Each key of some studies with each hostile value, and texts that are no study."""
    for name, base in (("rod", ROD), ("plate", PLATE), ("beam", BEAM)):
        yield from of_keys(name, base, list(leaves(base)), rng, few, {})
    deep = b"a = " + b"[" * 5000 + b"]" * 5000
    for said, text in (
        ("deep", deep),
        ("zero", b"\0" * 100),
        ("latin", b"title = '\xe9'"),
        ("mark", b"\xef\xbb\xbf" + text_of(ROD)),
    ):
        yield Input(said, {"s.toml": text}, ("check", "s.toml"))


def of_loads(rng: random.Random, few: bool) -> Iterator[Input]:
    """Keys of loads, rigid facets, large deflection and matrices; options of campbell."""
    for name, (base, sections) in NEW.items():
        places = [place for place in leaves(base) if place[0] in sections]
        rng.shuffle(places)
        yield from of_keys(name, base, places[:1] if few else places, rng, few, FILES)
    files = {"s.toml": text_of(LOADED), **FILES}
    for option, value in rng.sample(CAMPBELL, 2) if few else CAMPBELL:
        given = {"--speeds": "0:10:10", "--modes": "2"} | {option: value}
        words = [f"{key}={given[key]}" for key in given]
        yield Input(f"campbell {option} {value[:30]}", files, ("campbell", "s.toml", *words))
    warm = {"s.toml": text_of(WARM)}
    for said, data in damaged(FILES["t.csv"], rng, 2 if few else 200):
        yield Input(f"temperatures {said}", {**warm, "t.csv": data}, ("check", "s.toml"))


def text_of(study: dict[str, Any]) -> bytes:
    """The text of a study, whatever its values are."""
    lines = [f"{key} = {value_of(value)}" for key, value in study.items()]
    return ("\n".join(lines) + "\n").encode("utf-8", "surrogatepass")


def value_of(value: Any) -> str:
    """A value of TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {value_of(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(value_of, value)) + "]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def damaged(data: bytes, rng: random.Random, count: int) -> Iterator[tuple[str, bytes]]:
    """A file cut, and with flipped bytes and runs, at places."""
    for number in range(count):
        place = rng.randrange(len(data))
        bad = bytearray(data)
        if number % 4 == 0:
            bad = bad[:place]
        elif number % 4 == 3:
            bad[place : place + 40] = rng.randbytes(40)
        else:
            bad[place] ^= 1 << rng.randrange(8)
        yield f"{('cut', 'flip', 'flip', 'run')[number % 4]} at {place}", bytes(bad)


def of_meshes(rng: random.Random, few: bool, folder: Path) -> Iterator[Input]:
    """Meshes and a geometry, damaged."""
    import gmsh
    from small_meshes import saved_model

    endings = ("msh", "inp", "bdf", "unv", "vtk", "step")
    for ending in endings:
        path = folder / f"m.{ending}"
        with saved_model(path):
            gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
            gmsh.model.occ.synchronize()
            gmsh.model.addPhysicalGroup(3, [1], name="body")
            for tag, name in ((1, "left"), (2, "right")):
                gmsh.model.addPhysicalGroup(2, [tag], name=name)
            gmsh.option.setNumber("Mesh.MeshSizeMax", 1.0)
            gmsh.model.mesh.generate(3)
        study = copy.deepcopy(BEAM)
        study["mesh"] = {"file": path.name, "length_unit": "m"}
        if ending == "step":
            study["mesh"] |= {"element_size": 1.0, "ignore_declared_unit": True}
        study["groups"] = {"left": {"x": 0.0}, "right": {"x": 1.0}}
        for name, data in damaged(path.read_bytes(), rng, 1 if few else 200 // len(endings) + 1):
            files = {"s.toml": text_of(study), path.name: data}
            yield Input(f"{path.name} {name}", files, ("check", "s.toml"))


def of_branches(rng: random.Random, few: bool, folder: Path) -> Iterator[Input]:
    """A branch.h5, damaged, with its digest and without."""
    from fenics_nnm.run import run_study
    from fenics_nnm.study import study_from

    values = {**ROD, "continuation": {"energies": {"from": 0.9, "to": 1.1, "step": 0.1}}}
    run_study(study_from(values, folder / "s.toml"), toml(values), folder / "r")
    whole = (folder / "r" / "branch.h5").read_bytes()
    bare = whole[: whole.rindex(b"fenics_nnm digest ")]
    count = 2 if few else 50
    for kind, data in (("sealed", whole), ("bare", bare)):
        for name, bad in damaged(data, rng, count):
            arguments = ("export", "r", "--gamma", "1.1")
            yield Input(f"branch.h5 {kind} {name}", {"r/branch.h5": bad}, arguments)


def complaint(code: int, told: str) -> str:
    """What is wrong with how an input ended, empty if nothing is."""
    lines = [line for line in told.splitlines() if line.strip()]
    if code not in (0, 1, 2):
        return f"exit code {code}"
    if "this is a defect" in told or "Traceback" in told:
        return "a defect"
    if any(not line.startswith("fenics-nnm: ") for line in lines):
        return "other lines"
    if code and not lines:
        return "no line"
    return ""


def serve() -> None:
    """Run inputs, a line of JSON each, in this process."""
    from fenics_nnm.cli import main

    most = int(GIBIBYTES * 2**30)
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    answers = os.fdopen(os.dup(1), "w")
    for line in sys.stdin:
        asked = json.loads(line)
        os.chdir(asked["folder"])
        kept = os.dup(2)
        with open("told", "wb") as told, open(os.devnull, "wb") as nothing:
            os.dup2(told.fileno(), 2)
            os.dup2(nothing.fileno(), 1)
            try:
                code: Any = main(asked["arguments"])
            except SystemExit as end:
                code = end.code
            sys.stderr.flush()
        os.dup2(kept, 2)
        os.close(kept)
        answers.write(f"{code}\n")
        answers.flush()


class Server:
    """A process that runs inputs, and another one after it has died."""

    def __init__(self) -> None:
        self._start()

    def _start(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, __file__, "--serve"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment_of_child(),
        )

    def ended(self, folder: Path, arguments: tuple[str, ...]) -> int | None:
        """Exit code of an input, the signal below zero; none if it took too long."""
        import select

        assert self._process.stdin is not None and self._process.stdout is not None
        line = json.dumps({"folder": str(folder), "arguments": arguments})
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()
        if not select.select([self._process.stdout], [], [], SECONDS)[0]:
            self.stop()
            self._start()
            return None
        answer = self._process.stdout.readline()
        if answer:
            return int(answer)
        code = self._process.wait()
        self.stop()
        self._start()
        return code if code else -1

    def stop(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()


def parts(rng: random.Random, few: bool, folder: Path) -> dict[str, Iterator[Input]]:
    """Inputs by the part of the program that they are for."""
    return {
        "studies": of_studies(rng, few),
        "loads": of_loads(rng, few),
        "meshes": of_meshes(rng, few, folder),
        "branches": of_branches(rng, few, folder),
    }


def ended(server: Server, each: Input, place: Path, log: TextIO | None) -> str:
    """Run an input in a folder of its own; what is wrong with how it ended, empty if nothing is."""
    for file, data in each.files.items():
        (place / file).parent.mkdir(parents=True, exist_ok=True)
        (place / file).write_bytes(data)
    code = server.ended(place, each.arguments)
    told = (place / "told").read_text("utf-8", "replace")
    if log:
        print(f"{code} {each.name} | {told.strip()[:600]}", file=log, flush=True)
    fault = "too slow" if code is None else complaint(code, told)
    return f"{each.name}: {fault}: {told.strip()[-300:]!r}" if fault else ""


def fuzz(
    *,
    few: bool,
    seed: int = 1,
    only: str = "",
    shard: tuple[int, int] = (1, 1),
    log: TextIO | None = None,
) -> list[str]:
    """Run all inputs, or those of one part or shard; what is wrong, a line each.

    Args:
        few: A small part of them.
        seed: Of the random numbers.
        only: A part of the program, all without.
        shard: One of how many shards, from 1: every so many-th input.
        log: File of all that was told.
    """
    number, shards = shard
    wrong = []
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        folder = Path(name)
        server = Server()
        made = parts(random.Random(seed), few, folder)
        every = chain.from_iterable(made[part] for part in made if only in ("", part))
        count, slowest = 0, 0.0
        for each in islice(every, number - 1, None, shards):
            count += 1
            start = time.monotonic()
            fault = ended(server, each, folder / str(count), log)
            slowest = max(slowest, time.monotonic() - start)
            if fault:
                wrong.append(fault)
                print(fault, flush=True)  # noqa: T201
        server.stop()
    print(f"{count} inputs, the slowest {slowest:.1f} s, {len(wrong)} wrong")  # noqa: T201
    return wrong


def shard_of(text: str) -> tuple[int, int]:
    """One of how many shards, as in "1/2"."""
    number, shards = map(int, text.split("/"))
    if not 1 <= number <= shards:
        raise ValueError(f"shard {text}: must be as in 1/2")
    return number, shards


def main() -> int:
    """Run the script."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--few", action="store_true")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", choices=("studies", "loads", "meshes", "branches"))
    parser.add_argument("--shard", type=shard_of, default=(1, 1), help="as in 1/2")
    parser.add_argument("--log", type=argparse.FileType("w"), help="file of all that was told")
    arguments = parser.parse_args()
    if arguments.serve:
        serve()
        return 0
    del arguments.serve
    return int(bool(fuzz(**vars(arguments))))


if __name__ == "__main__":
    sys.exit(main())
