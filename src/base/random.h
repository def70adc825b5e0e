// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

namespace xview {

/// SplitMix64 (Steele, Lea, Flood 2014): small, fast, and the same on every platform. The standard
/// distributions differ between libraries, so the few that are needed are drawn here. All seeds
/// walk one cycle of states in equal steps, so each begins where its hash is: begun at the seeds
/// themselves, streams of near seeds would be one stream, some draws apart.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(hashOf(seed + kStep)) {}
  /// An independent stream for item `index` of a computation, so that threads do not matter.
  Random(std::uint64_t seed, std::uint64_t index)
      : Random(seed ^ (index * 0xD1342543DE82EF95ull + 1)) {
    next();
  }

  std::uint64_t next() { return hashOf(state_ += kStep); }
  double uniform() {
    return static_cast<double>(next() >> 11) * (1.0 / 9007199254740992.0);
  }  ///< [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Integer in [0, n); n > 0.
  std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>((static_cast<unsigned __int128>(next()) * n) >> 64);
  }
  double normal() {  ///< standard normal (Box-Muller)
    const double u = uniform() + 1e-300, v = uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * v);
  }

 private:
  static constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15ull;

  static std::uint64_t hashOf(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

}  // namespace xview
