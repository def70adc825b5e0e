# SPDX-License-Identifier: BSD-3-Clause
"""Builds the wheel with CMake, in build-python/ or $XVIEW_BUILD. See PEP 517."""
import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def _compiled(stage):
    """The package as CMake installs it, in stage/xview."""
    build = os.environ.get("XVIEW_BUILD", str(ROOT / "build-python"))
    flags = ["-DCMAKE_BUILD_TYPE=Release", "-DXVIEW_BUILD_TESTS=OFF", "-DXVIEW_PYTHON=ON",
             "-DXVIEW_PYTHON_DIR=.", f"-DPython3_EXECUTABLE={sys.executable}"]
    if shutil.which("ccache"):
        flags.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    if shutil.which("ninja") and not (pathlib.Path(build) / "CMakeCache.txt").exists():
        flags += ["-G", "Ninja"]
    flags += os.environ.get("XVIEW_CMAKE_FLAGS", "").split()
    cores = min(os.cpu_count() or 1, max(1, _free_gb()))  # the largest source needs about 1.1 GB
    for command in (["cmake", "-S", str(ROOT), "-B", build, *flags],
                    ["cmake", "--build", build, "--target", "xview_python", "--parallel", str(cores)],
                    ["cmake", "--install", build, "--component", "python", "--prefix", stage]):
        subprocess.run(command, check=True)


def _free_gb():
    return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 1_200_000_000


def _digest(data):
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    version = re.search(r"project\(xview VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{platform}"
    info = f"xview-{version}.dist-info"
    name = f"xview-{version}-{tag}.whl"
    with tempfile.TemporaryDirectory() as stage:
        _compiled(stage)
        files = {str(path.relative_to(stage)): path.read_bytes()
                 for path in sorted(pathlib.Path(stage, "xview").iterdir())}
    files[f"{info}/METADATA"] = (f"Metadata-Version: 2.1\nName: xview\nVersion: {version}\n"
                                 "Summary: Find where a robot is in a semantic map\n"
                                 "License: BSD-3-Clause\nRequires-Dist: numpy\n").encode()
    files[f"{info}/WHEEL"] = ("Wheel-Version: 1.0\nGenerator: xview\nRoot-Is-Purelib: false\n"
                              f"Tag: {tag}\n").encode()
    record = [f"{path},sha256={_digest(data)},{len(data)}" for path, data in files.items()]
    files[f"{info}/RECORD"] = "\n".join([*record, f"{info}/RECORD,,", ""]).encode()
    with zipfile.ZipFile(pathlib.Path(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            wheel.writestr(path, data)
    return name


def build_sdist(sdist_directory, config_settings=None):
    raise NotImplementedError("pip install the sources, which are a git repository")
