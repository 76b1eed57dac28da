# SPDX-License-Identifier: MIT
"""Builds the Python package for pip: CMake compiles the module, setuptools makes the wheel (docs/python.md).

CMAKE_ARGS in the environment goes to CMake, as -DCMAKE_PREFIX_PATH=FOLDER where xsimd is in a place of its own.
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

here = pathlib.Path(__file__).resolve().parent


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        if shutil.which("cmake") is None:
            sys.exit("cmake is missing, which compiles maxlogdet; on Debian: apt-get install cmake g++ libxsimd-dev "
                     "pybind11-dev python3-dev")
        build = pathlib.Path(self.build_temp).resolve() / "cmake"
        # Keeps compiled objects, but not the configuration: pip's cmake and ninja are in another folder next time.
        shutil.rmtree(build / "CMakeFiles", ignore_errors=True)
        (build / "CMakeCache.txt").unlink(missing_ok=True)
        # Only the module, and no library that a wheel cannot contain.
        parts = [f"-DMAXLOGDET_BUILD_{part}=OFF" for part in ("PROGRAM", "TESTS", "BENCHMARKS", "TBB")]
        configure = ["cmake", "-S", here, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DMAXLOGDET_INSTALL=OFF",
                     "-DMAXLOGDET_BUILD_PYTHON=ON", f"-DPython3_EXECUTABLE={sys.executable}", *parts]
        if shutil.which("ninja"):
            configure.append("-GNinja")
        try:
            import pybind11  # pip's package; otherwise CMake searches the system's
            configure.append(f"-Dpybind11_DIR={pybind11.get_cmake_dir()}")
        except ImportError:
            pass
        compile_module = ["cmake", "--build", build, "--target", "maxlogdet_python", "--parallel", str(os.cpu_count())]
        for command in configure + shlex.split(os.environ.get("CMAKE_ARGS", "")), compile_module:
            status = subprocess.call([str(word) for word in command])
            if status != 0:
                sys.exit(f"{command[0]} failed with exit code {status}; its messages are above")
        module = pathlib.Path(self.get_ext_fullpath(extension.name))
        module.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(build / "python" / "maxlogdet" / module.name, module)


project = re.search(r'project\(maxlogdet VERSION (\S+).*?DESCRIPTION "([^"]+)"', (here / "CMakeLists.txt").read_text(),
                    re.DOTALL)
(here / "build").mkdir(exist_ok=True)
setup(
    name="maxlogdet",
    version=project.group(1),
    description=project.group(2),
    long_description=(here / "docs" / "python.md").read_text(),
    long_description_content_type="text/markdown",
    author="The maxlogdet authors",
    license="MIT",
    license_files=["LICENSE", "LICENSE.xsimd"],  # xsimd is compiled in
    python_requires=">=3.8",
    install_requires=["numpy"],
    packages=["maxlogdet"],
    package_dir={"maxlogdet": "python/maxlogdet"},
    package_data={"maxlogdet": ["*.pyi", "py.typed"]},
    ext_modules=[Extension("maxlogdet._core", sources=[])],
    cmdclass={"build_ext": CMakeBuild},
    options={"egg_info": {"egg_base": "build"}},  # keeps the checkout unchanged
    zip_safe=False,
)
