// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "xview/base/frame.h"

namespace xview {

/// A segmentation network, run by OpenCV on the processor. One image at a time.
class Network {
 public:
  /// An ONNX model, or any other that OpenCV reads. Throws Error with the layer that it cannot
  /// read, or if the module xview_network is missing.
  static std::unique_ptr<Network> open(const std::string& model_path, NetworkInput input);
  virtual ~Network() = default;
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  /// Class ids of the pixels of an image, in a size of the caller's choice. The network may answer
  /// with scores of classes (1 x classes x rows x columns, at any stride) or with one channel of
  /// class numbers. Throws Error if it answers otherwise, or with a class that has no id.
  virtual LabelImage label(const ColorImage& image, int width, int height) = 0;

 protected:
  Network() = default;
};

}  // namespace xview
