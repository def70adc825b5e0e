# SPDX-License-Identifier: BSD-3-Clause
# Types of the compiled module. Shapes and units are in the docstrings, which help() prints.
import os
from typing import Any, Callable, Iterator, Literal, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

Path = Union[str, "os.PathLike[str]"]
Floats = Union[NDArray[np.float32], NDArray[np.float64]]
Ids = NDArray[Any]  # of integers
Clouds = Union[Floats, Sequence[Floats]]
Classes = Union[str, "os.PathLike[str]", Mapping[int, str]]
Option = Union[bool, int, float, str, Sequence[float], Mapping[str, Any], None]

__version__: str

class Error(RuntimeError):
    """Something is not as it should be: a file, a disk, a list of poses."""

class UsageError(Error, ValueError):
    """What was asked for makes no sense."""

class Recording:
    """Frames of a file or folder, or of a simulated drive, in order."""

    def __len__(self) -> int: ...
    def __getitem__(self, frames: Union[int, slice]) -> Recording:
        """Its frames as a recording of their own; nothing is read."""
    def __iter__(self) -> Iterator[Recording]:
        """Frame by frame."""
    @property
    def name(self) -> str: ...
    @property
    def sensor(self) -> Literal["camera", "lidar", "cloud"]: ...
    @property
    def classes(self) -> dict[int, str]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def poses(self) -> NDArray[np.float64]:
        """T_odom_sensor of all frames (N, 4, 4) [m]."""
    @property
    def truth(self) -> Optional[NDArray[np.float64]]:
        """T_map_sensor of all frames of a simulated drive (N, 4, 4) [m]."""
    @property
    def stamps(self) -> NDArray[np.float64]:
        """Times of all frames (N,) [s]."""
    def points(self, frame: int) -> NDArray[Any]:
        """(M, 3) in the frame of the sensor [m]."""
    def labels(self, frame: int) -> NDArray[np.uint32]:
        """(M,) class ids."""
    def depth(self, frame: int) -> NDArray[np.float32]:
        """(H, W) along the optical axis [m]; 0 = no measurement."""
    def label_image(self, frame: int) -> NDArray[np.uint16]:
        """(H, W) class ids."""
    def cloud(
        self, voxel_m: float = 0.1, **options: Option
    ) -> Tuple[NDArray[Any], NDArray[np.uint32]]:
        """Points (M, 3) in the odometry frame [m] and class ids (M,)."""
    def save(self, folder: Path, threads: int = 0) -> None: ...

class Graph:
    """A semantic graph: things with a class and a place, and edges between neighbours."""

    def __init__(
        self,
        positions: Floats,
        labels: Ids,
        edges: Optional[Ids] = None,
        classes: Optional[Classes] = None,
        **options: Option,
    ) -> None: ...
    def __len__(self) -> int: ...
    @property
    def positions(self) -> NDArray[np.float64]:
        """(V, 3) [m]."""
    @property
    def extents(self) -> NDArray[np.float64]:
        """(V, 3) [m]."""
    @property
    def labels(self) -> NDArray[np.uint32]:
        """(V,) class ids."""
    @property
    def edges(self) -> NDArray[np.uint32]:
        """(E, 2) vertex indices."""
    @property
    def classes(self) -> dict[int, str]: ...
    def save(self, path: Path) -> None: ...

class Map:
    """A place that is kept, to localize in. z is up."""

    @staticmethod
    def build(
        source: Source,
        labels: Optional[Union[Ids, Sequence[Ids]]] = None,
        poses: Optional[Union[NDArray[np.float64], Sequence[NDArray[np.float64]]]] = None,
        stamps: Optional[Union[float, Sequence[float], NDArray[np.float64]]] = None,
        classes: Optional[Classes] = None,
        **options: Option,
    ) -> Map: ...
    @staticmethod
    def load(path: Path) -> Map: ...
    def save(self, path: Path) -> None: ...
    def append(
        self,
        source: Source,
        labels: Optional[Union[Ids, Sequence[Ids]]] = None,
        poses: Optional[Union[NDArray[np.float64], Sequence[NDArray[np.float64]]]] = None,
        stamps: Optional[Union[float, Sequence[float], NDArray[np.float64]]] = None,
        classes: Optional[Classes] = None,
        *,
        force: bool = False,
        **options: Option,
    ) -> None: ...
    @property
    def path(self) -> str: ...
    @property
    def sources(self) -> list[str]: ...
    @property
    def size(self) -> str: ...
    @property
    def classes(self) -> dict[int, str]: ...
    @property
    def graph(self) -> Graph: ...
    @property
    def points(self) -> NDArray[Any]:
        """(M, 3) [m]."""
    @property
    def labels(self) -> NDArray[np.uint32]:
        """(M,) class ids."""
    @property
    def poses(self) -> NDArray[np.float64]:
        """T_map_sensor of its key frames (K, 4, 4) [m]."""
    @property
    def notes(self) -> list[str]: ...

Source = Union[Clouds, Recording, Graph, Map, Sequence[Union[Recording, Graph, Map]]]

class Fix:
    """The answer to one query; true if it is accepted."""

    def __bool__(self) -> bool: ...
    @property
    def accepted(self) -> bool: ...
    @property
    def status(self) -> Literal["accepted", "ambiguous", "rejected"]: ...
    @property
    def reason(self) -> str: ...
    @property
    def reason_code(self) -> str: ...
    @property
    def budget_exhausted(self) -> Optional[Literal["time", "memory"]]: ...
    @property
    def confidence(self) -> float: ...
    @property
    def p_wrong(self) -> float: ...
    @property
    def T_map_query(self) -> Optional[NDArray[np.float64]]:
        """(4, 4) of the best hypothesis [m]; None without any."""
    @property
    def T_map_sensor(self) -> Optional[NDArray[np.float64]]:
        """(4, 4), pose of the last frame [m]; None without a hypothesis."""
    @property
    def covariance(self) -> Optional[NDArray[np.float64]]:
        """(6, 6) of T_map_sensor: x y z [m], rotation vector [rad], map frame."""
    @property
    def hypotheses(self) -> list[dict[str, Any]]: ...
    @property
    def witnesses(self) -> dict[str, float]: ...
    @property
    def scale(self) -> float: ...
    @property
    def inliers(self) -> int: ...
    @property
    def vertices(self) -> int: ...
    @property
    def putative(self) -> NDArray[np.uint32]:
        """(K, 2): vertex of the query, vertex of the map."""
    @property
    def kept(self) -> NDArray[np.uint32]:
        """(K, 2): vertex of the query, vertex of the map."""
    @property
    def trajectory(self) -> NDArray[np.float64]:
        """T_map_sensor of every frame (N, 4, 4) [m]."""
    @property
    def timing_ms(self) -> dict[str, float]: ...
    @property
    def notes(self) -> list[str]: ...
    def _repr_html_(self) -> str: ...
    def to_json(self) -> str: ...
    def to_dict(self) -> dict[str, Any]: ...
    @staticmethod
    def from_json(line: str) -> Fix: ...

class Localizer:
    """Finds queries in one map."""

    def __init__(
        self,
        map: Map,
        risk: float = 0.01,
        *,
        timeout: float = 0,
        max_memory: float = 0,
        **options: Option,
    ) -> None: ...
    def localize(
        self,
        query: Union[Clouds, Recording, Graph, Map],
        labels: Optional[Union[Ids, Sequence[Ids]]] = None,
        poses: Optional[Union[NDArray[np.float64], Sequence[NDArray[np.float64]]]] = None,
        stamps: Optional[Union[float, Sequence[float], NDArray[np.float64]]] = None,
        classes: Optional[Classes] = None,
        *,
        last_m: float = 150,
    ) -> Fix: ...
    def localize_windows(
        self,
        recording: Recording,
        window: int,
        stride: int = 0,
        *,
        on_fix: Optional[Callable[[Fix], object]] = None,
    ) -> list[Fix]: ...
    def check(
        self,
        query: Union[Clouds, Recording, Graph, Map],
        T_map_query: Union[NDArray[np.float64], Sequence[NDArray[np.float64]]],
        labels: Optional[Union[Ids, Sequence[Ids]]] = None,
        poses: Optional[Union[NDArray[np.float64], Sequence[NDArray[np.float64]]]] = None,
        stamps: Optional[Union[float, Sequence[float], NDArray[np.float64]]] = None,
        classes: Optional[Classes] = None,
        *,
        reach_m: float = 0.0,
        last_m: float = 150,
    ) -> list[dict[str, Any]]: ...
    def judge(
        self,
        query: Union[Clouds, Recording, Graph, Map],
        T_map_query: Union[NDArray[np.float64], Sequence[NDArray[np.float64]]],
        labels: Optional[Union[Ids, Sequence[Ids]]] = None,
        poses: Optional[Union[NDArray[np.float64], Sequence[NDArray[np.float64]]]] = None,
        stamps: Optional[Union[float, Sequence[float], NDArray[np.float64]]] = None,
        classes: Optional[Classes] = None,
        *,
        last_m: float = 150,
    ) -> list[Fix]: ...
    @property
    def classes(self) -> dict[int, str]: ...

class Tracker:
    """Follows a robot, as `xview follow` does."""

    def __init__(self, localizer: Localizer, window: int = 1) -> None: ...
    def add(
        self,
        points: Floats,
        T_odom_sensor: NDArray[np.float64],
        stamp: float = 0.0,
        labels: Optional[Ids] = None,
        classes: Optional[Classes] = None,
    ) -> Optional[Fix]: ...

class Descriptors:
    """The walks of every vertex of a graph."""

    def __len__(self) -> int: ...
    def __getitem__(self, vertex: int) -> dict[Tuple[int, ...], int]: ...
    def similarity(self, vertex: int, other: Descriptors, of_other: int) -> float: ...

def read(
    path: Path,
    *,
    labels: str = "",
    frames: str = "",
    kind: str = "",
    label_field: str = "",
    instance_field: str = "",
    mount: str = "",
    topic: str = "",
    odometry: str = "",
) -> Union[Recording, Graph, Map]: ...

def load_map(path: Path) -> Map: ...
def graph(
    source: Source,
    labels: Optional[Union[Ids, Sequence[Ids]]] = None,
    poses: Optional[Union[NDArray[np.float64], Sequence[NDArray[np.float64]]]] = None,
    stamps: Optional[Union[float, Sequence[float], NDArray[np.float64]]] = None,
    classes: Optional[Classes] = None,
    **options: Option,
) -> Graph: ...
def walks(graph: Graph, vertex: int, **options: Option) -> list[Tuple[Tuple[int, ...], float]]: ...
def descriptors(
    graph: Graph, alphabet_of: Optional[Graph] = None, **options: Option
) -> Descriptors: ...
def match(
    query: Graph, map: Graph, **options: Option
) -> Tuple[NDArray[np.uint32], NDArray[np.float32]]: ...
def consensus(
    query: Graph, map: Graph, pairs: Ids, **options: Option
) -> Tuple[Optional[NDArray[np.float64]], NDArray[np.uint32]]: ...
def evaluate(
    fixes: Union[Sequence[Union[Fix, NDArray[np.float64]]], NDArray[np.float64], Path],
    truth: Union[NDArray[np.float64], Sequence[NDArray[np.float64]], Path],
    within_m: float = 5.0,
    negatives: Union[Sequence[Fix], Path] = (),
) -> dict[str, Any]: ...
def simulate(**options: Option) -> dict[str, Recording]: ...
