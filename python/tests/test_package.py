# SPDX-License-Identifier: MIT
"""The package as a whole: names, types, the code of the documentation, and the installed files."""
import ast
import inspect
import os
import pathlib
import re
import subprocess
import sys

import pytest

import maxlogdet

SOURCE = pathlib.Path(os.environ.get("MAXLOGDET_SOURCE", pathlib.Path(__file__).parents[2]))


def test_the_version_is_that_of_the_project():
    text = (SOURCE / "CMakeLists.txt").read_text()
    assert maxlogdet.__version__ == re.search(r"project\(maxlogdet VERSION (\S+)", text).group(1)
    assert re.fullmatch("[a-z0-9_]+", maxlogdet.isa()) and maxlogdet.isa() != "none"


def parameters_of(function):
    """Names with defaults, as 'name=default', of a function of the stub."""
    arguments = function.args
    defaults = [None] * (len(arguments.args) - len(arguments.defaults)) + arguments.defaults
    pairs = [*zip(arguments.args, defaults), *zip(arguments.kwonlyargs, arguments.kw_defaults)]
    return [a.arg if d is None else f"{a.arg}={ast.literal_eval(d)!r}" for a, d in pairs if a.arg != "self"]


def actual_parameters_of(function):
    parameters = inspect.signature(function).parameters.values()
    return [p.name if p.default is p.empty else f"{p.name}={p.default!r}" for p in parameters if p.name != "self"]


def test_the_stub_matches_the_module():
    stub = ast.parse((pathlib.Path(maxlogdet.__file__).parent / "__init__.pyi").read_text())
    classes = {node.name: node for node in stub.body if isinstance(node, ast.ClassDef)}
    functions = {node.name: node for node in stub.body if isinstance(node, ast.FunctionDef)}
    aliases = [node for node in stub.body if isinstance(node, ast.Assign) and isinstance(node.value, ast.Name)]
    functions.update({node.targets[0].id: functions[node.value.id] for node in aliases if node.value.id in functions})
    variables = {node.target.id for node in stub.body if isinstance(node, ast.AnnAssign)}
    assert sorted([*classes, *functions, *variables]) == sorted([*maxlogdet.__all__, "__version__"])
    for name, function in functions.items():
        assert actual_parameters_of(getattr(maxlogdet, name)) == parameters_of(function), name
    for name, stub_class in classes.items():
        actual = getattr(maxlogdet, name)
        assert actual.__module__ == "maxlogdet"
        assert actual.__doc__
        members = {node.name: node for node in stub_class.body if isinstance(node, ast.FunctionDef)}
        members.update({node.target.id: node for node in stub_class.body if isinstance(node, ast.AnnAssign)})
        if name == "SelectionError":
            continue
        public = {member for member in vars(actual) if not member.startswith("_")}
        assert public == {member for member in members if not member.startswith("_")}, name
        for member, node in members.items():
            if isinstance(node, ast.AnnAssign) or member in ("__len__", "__iter__", "__next__", "__enter__", "__exit__"):
                assert hasattr(actual, member)
            elif any(decorator.id == "property" for decorator in node.decorator_list):
                assert isinstance(inspect.getattr_static(actual, member), property), f"{name}.{member}"
            elif member == "__init__":  # its signature is the first line of the class' documentation
                signature = ast.parse(f"def {actual.__doc__.splitlines()[0]}: ...").body[0]
                assert parameters_of(signature) == parameters_of(node), name
            else:
                assert actual_parameters_of(getattr(actual, member)) == parameters_of(node), f"{name}.{member}"
                assert getattr(actual, member).__doc__


def test_the_code_of_the_documentation_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```$", (SOURCE / "docs" / "python.md").read_text(),
                        re.DOTALL | re.MULTILINE)
    assert len(blocks) >= 3
    names = {}
    for number, block in enumerate(blocks):
        exec(compile(block, f"docs/python.md, block {number}", "exec"), names)
    assert len(names["selected"]) == 200
    assert len(names["selection"]) == 200


def test_an_installed_package_can_be_imported(tmp_path):
    if os.environ.get("MAXLOGDET_CAN_INSTALL") != "1":
        pytest.skip("no build folder with install rules given (MAXLOGDET_BUILD, MAXLOGDET_CMAKE)")
    first = tmp_path / "first"
    subprocess.run([os.environ["MAXLOGDET_CMAKE"], "--install", os.environ["MAXLOGDET_BUILD"], "--component", "python",
                    "--prefix", str(first)], check=True, capture_output=True)
    moved = tmp_path / "moved"
    first.rename(moved)
    packages = list(moved.glob("**/maxlogdet/__init__.py"))
    assert len(packages) == 1
    site = packages[0].parents[1]
    program = ("import maxlogdet, numpy; print(maxlogdet.__file__); "
               "print(len(maxlogdet.select_blocks(numpy.random.default_rng(1).normal(size=(50, 2, 6)), 7)))")
    environment = {**os.environ, "PYTHONPATH": str(site)}
    run = subprocess.run([sys.executable, "-B", "-c", program], env=environment, text=True, capture_output=True,
                         cwd=tmp_path)
    assert run.stdout.splitlines() == [str(packages[0]), "7"], run.stderr
    assert (site / "maxlogdet" / "__init__.pyi").stat().st_size > 0
    assert (site / "maxlogdet" / "py.typed").exists()


def test_the_module_exports_nothing_of_the_library():
    nm = "/usr/bin/nm"
    if not os.path.exists(nm):
        pytest.skip("no nm")
    library = next(pathlib.Path(maxlogdet.__file__).parent.glob("_core*.so"))
    symbols = subprocess.run([nm, "-D", "--defined-only", str(library)], check=True, text=True,
                             capture_output=True).stdout
    ours = [line for line in symbols.splitlines() if re.search(r"\b_Z(T[VIS])?NK?9maxlogdet", line)]
    assert ours == []  # instances of std's templates for our types may be exported: std sets their visibility
    assert "PyInit__core" in symbols
