// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

/// The function of the module xview_features: normals of points by their neighbours within a
/// radius, which point either way and are NaN where there are too few, or, with them, a Fast Point
/// Feature Histogram of each point. Deterministic for any number of threads (0 = all cores).
extern "C" void xviewNormals(double radius, unsigned int threads,
                             pcl::PointCloud<pcl::PointNormal>& points);
extern "C" void xviewPointFeatures(const pcl::PointCloud<pcl::PointNormal>& points, double radius,
                                   unsigned int threads,
                                   pcl::PointCloud<pcl::FPFHSignature33>& features);
