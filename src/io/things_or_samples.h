// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview::io {

/// Whether the vertices of a .ply are things, each with a place of its own, and not samples of
/// surfaces. Edges, and properties that only graphs have (observations, sigma, extent_x), say so;
/// faces, or no label at all, say that they are not. Else the vertices themselves tell: things have
/// instances of their own, or are a metre and more apart, or at least have neighbours of other
/// classes; samples lie close, among their like. That is a guess; if it is not a clear one,
/// `guess`, if given, receives a sentence about it. Of a cloud no more is read than it takes to
/// know. Throws Error.
bool holdsGraph(const std::string& path, std::string* guess = nullptr);

}  // namespace xview::io
