// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

/// The functions of the module xview_features: normals of points by their neighbours within a
/// radius, NaN where there are too few, and, with them, a Fast Point Feature Histogram of each
/// point. On one thread: what runs out of memory in a thread of OpenMP ends the program.
extern "C" void xviewNormals(double radius, pcl::PointCloud<pcl::PointNormal>& points);
extern "C" void xviewPointFeatures(const pcl::PointCloud<pcl::PointNormal>& points, double radius,
                                   pcl::PointCloud<pcl::FPFHSignature33>& features);
