"""Breaks the safety machines on purpose, one small fault at a time, and sees whether their tests notice.

    python -m tests.mutation [PART OF A MUTANT'S NAME, such as rover.drive:]

Every comparison, boundary, negation, operator and constant of the modules in `TARGETS` is changed in turn. A
mutant that no test notices fails the run, unless `mutation_equivalent.toml` says why it makes no difference. An
entry there that no mutant answers to fails it too, so the list cannot grow old.
"""

import ast
import copy
import importlib
import os
import signal
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[1]
EQUIVALENT = Path(__file__).with_name("mutation_equivalent.toml")
TESTS = {
    "timonel.core.command": ("tests/unit/core/test_command.py", "tests/property/test_exploration.py"),
    "timonel.nmea2000.claim": ("tests/unit/nmea2000/test_claim.py",),
    "timonel.vehicles.boat.pilot": ("tests/unit/boat/test_pilot.py", "tests/property/test_exploration.py"),
    "timonel.vehicles.boat.helm": (
        "tests/unit/boat/test_helm.py",
        "tests/conformance/test_boat_vectors.py",
        "tests/property/test_exploration.py",
    ),
    "timonel.vehicles.rover.drive": ("tests/unit/rover/test_drive.py", "tests/property/test_rover_exploration.py"),
    "timonel.vehicles.rover.helm": ("tests/unit/rover/test_helm.py", "tests/property/test_rover_exploration.py"),
}
PATIENCE = 120  # s for the tests of one mutant; a mutant that hangs is noticed
UNIT_PATIENCE = 20  # the same for unit tests, which take a second or two

COMPARISONS: dict[type[ast.cmpop], list[type[ast.cmpop]]] = {
    ast.Lt: [ast.LtE, ast.GtE],
    ast.LtE: [ast.Lt, ast.Gt],
    ast.Gt: [ast.GtE, ast.LtE],
    ast.GtE: [ast.Gt, ast.Lt],
    ast.Eq: [ast.NotEq],
    ast.NotEq: [ast.Eq],
    ast.Is: [ast.IsNot],
    ast.IsNot: [ast.Is],
    ast.In: [ast.NotIn],
    ast.NotIn: [ast.In],
}
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.FloorDiv,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Add,
}


def variants(node: ast.AST) -> Iterator[ast.AST]:
    """The faults that can be made of one node."""
    match node:
        case ast.Compare(ops=[operator, *_]):
            for other in COMPARISONS[type(operator)]:
                mutant = copy.deepcopy(node)
                mutant.ops[0] = other()
                yield mutant
        case ast.BoolOp(op=operator):
            mutant = copy.deepcopy(node)
            mutant.op = ast.Or() if isinstance(operator, ast.And) else ast.And()
            yield mutant
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield operand
        case ast.BinOp(op=operator) if type(operator) in OPERATORS:
            mutant = copy.deepcopy(node)
            mutant.op = OPERATORS[type(operator)]()
            yield mutant
        case ast.IfExp() | ast.If():
            mutant = copy.deepcopy(node)
            mutant.test = ast.UnaryOp(ast.Not(), mutant.test)
            yield mutant
        case ast.Constant(value=bool() as value):
            yield ast.Constant(not value)
        case ast.Constant(value=int() | float() as number):
            yield ast.Constant(number + 1)
            yield ast.Constant(number - 1)
        case ast.Constant(value=str() as text):
            yield ast.Constant(text + "!")


def is_call(node: ast.AST) -> bool:
    return isinstance(node, ast.Call)


def is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


class Sites(ast.NodeVisitor):
    """Every place where a fault can be made: the function it is in, the node, and how to put another there."""

    def __init__(self) -> None:
        self.found: list[tuple[str, ast.AST, ast.AST, str, int | None]] = []
        self._within: list[str] = []

    def generic_visit(self, node: ast.AST) -> None:
        named = isinstance(node, ast.FunctionDef | ast.ClassDef)
        if named:
            self._within.append(node.name)  # type: ignore[attr-defined]
        for field, value in ast.iter_fields(node):
            if field in ("annotation", "returns", "decorator_list", "type_params", "keywords") and not is_call(node):
                continue  # types, and how a struct is stored in memory
            if isinstance(value, list):
                for index, child in enumerate(value):
                    self._site(node, field, index, child)
            else:
                self._site(node, field, None, value)
        if named:
            self._within.pop()

    def _site(self, parent: ast.AST, field: str, index: int | None, child: object) -> None:
        if not isinstance(child, ast.AST) or is_docstring(child):
            return
        if isinstance(parent, ast.Import | ast.ImportFrom):
            return
        self.found.append((".".join(self._within) or "module", child, parent, field, index))
        self.visit(child)


def short(node: ast.AST) -> str:
    """A node in one line; of a statement its condition is enough."""
    return f"if {ast.unparse(node.test)}" if isinstance(node, ast.If) else ast.unparse(node)


def mutants(source: str) -> Iterator[tuple[str, str]]:
    """Name and source of every mutant. A name says what was changed where, not in which line."""
    tree = ast.parse(source)
    sites = Sites()
    sites.visit(tree)
    names: Counter[str] = Counter()
    for within, node, parent, field, index in sites.found:
        for variant in variants(node):
            name = f"{within}: {short(node)} -> {short(variant)}"
            names[name] += 1
            if names[name] > 1:
                name += f" ({names[name]})"
            put(parent, field, index, variant)
            yield name, ast.unparse(ast.fix_missing_locations(copy.deepcopy(tree)))
            put(parent, field, index, node)


def put(parent: ast.AST, field: str, index: int | None, node: ast.AST) -> None:
    if index is None:
        setattr(parent, field, node)
    else:
        getattr(parent, field)[index] = node


def noticed(target: str, source: str) -> bool:
    """Run the tests of `target` with `source` in its place, each file in a process of its own."""
    return any(fails(target, source, tests) for tests in TESTS[target])


def fails(target: str, source: str, tests: str) -> bool:
    child = os.fork()
    if child == 0:
        run_tests(target, source, tests)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status) != 0


def run_tests(target: str, source: str, tests: str) -> None:
    """Never returns: the process ends with the tests' verdict."""
    signal.alarm(UNIT_PATIENCE if tests.startswith("tests/unit") else PATIENCE)
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    code = 1
    try:
        module = ModuleType(target)
        module.__package__ = target.rpartition(".")[0]
        importlib.import_module(module.__package__)
        sys.modules[target] = module
        exec(compile(source, target, "exec"), module.__dict__)
        setattr(sys.modules[module.__package__], target.rpartition(".")[2], module)
        import pytest

        plugins = ("cacheprovider", "xdist", "xdist.looponfail", "pytest_cov", "timeout", "hypothesispytest")
        options = [word for plugin in plugins for word in ("-p", f"no:{plugin}")]
        code = pytest.main(["-x", "-q", "-o", "addopts=", "-o", "timeout=0", "-W", "ignore", *options, tests])
    finally:
        os._exit(int(code != 0))


def prepare() -> None:
    """Import once, before the forks, what no mutant is part of."""
    for name in ("pytest", "msgspec", "timonel.nmea0183.registry", "timonel.nmea2000.registry"):
        importlib.import_module(name)
    for target in (*TESTS, *DEPENDENTS):
        assert target not in sys.modules, f"{target} is imported already, so a mutant of it would not be seen"


DEPENDENTS = ("timonel.vehicles.boat.vehicle", "timonel.vehicles.rover.vehicle", "tests.property.exploration")


def main(wanted: str = "") -> int:
    os.chdir(ROOT)
    prepare()
    equivalent = tomllib.loads(EQUIVALENT.read_text())
    jobs = []
    for target in TESTS:
        path = ROOT / "src" / (target.replace(".", "/") + ".py")
        chosen = [(target, name, source) for name, source in mutants(path.read_text()) if wanted in f"{target}: {name}"]
        if chosen and noticed(target, path.read_text()):
            raise SystemExit(f"{target}: its tests fail without any mutation")
        jobs += chosen
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        verdicts = list(pool.map(lambda job: noticed(job[0], job[2]), jobs))
    survivors = {f"{target}: {name}" for (target, name, _), seen in zip(jobs, verdicts, strict=True) if not seen}
    explained = {f"{target}: {name}" for target, entries in equivalent.items() for name in entries}
    unexplained = sorted(survivors - explained)
    stale = [] if wanted else sorted(explained - survivors)
    for name in unexplained:
        print(f"not noticed: {name}")
    for name in stale:
        print(f"listed as equivalent, but noticed or gone: {name}")
    kinds = f"{len(jobs)} mutants, {len(jobs) - len(survivors)} noticed, {len(survivors) - len(unexplained)} equivalent"
    print(f"{kinds}, {len(unexplained)} not noticed")
    return 1 if unexplained or stale else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:2]))
