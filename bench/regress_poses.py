# SPDX-License-Identifier: BSD-3-Clause
"""Poses as 4x4 matrices of nested lists; T_a_b takes points of b to a."""
import math


def product(*matrices):
    result = matrices[0]
    for other in matrices[1:]:
        result = [[sum(result[i][k] * other[k][j] for k in range(4)) for j in range(4)] for i in range(4)]
    return result


def inverse(T):
    R = [[T[j][i] for j in range(3)] for i in range(3)]
    return [R[i] + [-sum(R[i][k] * T[k][3] for k in range(3))] for i in range(3)] + [[0, 0, 0, 1]]


def from_quaternion(position, quaternion):
    x, y, z, w = (v / math.sqrt(sum(u * u for u in quaternion)) for v in quaternion)
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), position[0]],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), position[1]],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), position[2]], [0, 0, 0, 1]]


def from_numbers(numbers):
    """A TUM line (8), the upper three rows (12), or a whole matrix (16)."""
    v = [float(word) for word in numbers]
    if len(v) == 8:
        return from_quaternion(v[1:4], v[4:8])
    return [v[0:4], v[4:8], v[8:12], [0, 0, 0, 1]]


def turned_about_z(angle, x=0.0, y=0.0, z=0.0):
    c, s = math.cos(angle), math.sin(angle)
    return [[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]


def normalised_error_squared(covariance, T_estimate, T_true):
    """e^T C^-1 e with e = position and rotation vector of the left increment in the map frame."""
    R = product(T_true, inverse(T_estimate))
    angle = math.acos(max(-1.0, min(1.0, (R[0][0] + R[1][1] + R[2][2] - 1) / 2)))
    scale = angle / (2 * math.sin(angle)) if 1e-9 < angle < math.pi - 1e-6 else 0.5
    turn = [scale * (R[2][1] - R[1][2]), scale * (R[0][2] - R[2][0]), scale * (R[1][0] - R[0][1])]
    error = [T_true[i][3] - T_estimate[i][3] for i in range(3)] + turn
    # Cholesky: C = L L^T, then |L^-1 e|^2.
    C, L, solved = [covariance[6 * i:6 * i + 6] for i in range(6)], [[0.0] * 6 for _ in range(6)], []
    for i in range(6):
        for j in range(i + 1):
            rest = C[i][j] - sum(L[i][k] * L[j][k] for k in range(j))
            if i == j and rest <= 0:
                return math.inf
            L[i][j] = math.sqrt(rest) if i == j else rest / L[j][j]
        solved.append((error[i] - sum(L[i][k] * solved[k] for k in range(i))) / L[i][i])
    return sum(v * v for v in solved)
