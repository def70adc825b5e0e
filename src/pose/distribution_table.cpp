// SPDX-License-Identifier: BSD-3-Clause
#include "distribution_table.h"

namespace xview {
namespace {

/// Cells in a row of so many lie next to one another in the hash table: neighbours share its cache
/// lines.
constexpr int kRowBits = 3;

std::uint64_t rowHash(const CellKey& k) {
  std::uint64_t h = static_cast<std::uint32_t>(k.x >> kRowBits) * 0x9E3779B97F4A7C15ull;
  h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(k.y) * 0xBF58476D1CE4E5B9ull;
  h = (h ^ (h >> 29)) + static_cast<std::uint32_t>(k.z) * 0x94D049BB133111EBull;
  h = (h ^ (h >> 30)) + k.group * 0xD1342543DE82EF95ull;
  return h ^ (h >> 32);
}

std::uint32_t tagOf(std::uint64_t hash) { return static_cast<std::uint32_t>(hash >> 32); }

}  // namespace

std::uint64_t CellKey::hash() const {
  return (rowHash(*this) << kRowBits) | static_cast<std::uint64_t>(x & ((1 << kRowBits) - 1));
}

std::size_t DistributionTable::slotOf(const CellKey& key, std::uint64_t hash) const {
  const std::size_t mask = slots_.size() - 1;
  const std::uint32_t tag = tagOf(hash);
  std::size_t slot = hash & mask;
  while (slots_[slot].distribution >= 0 &&
         (slots_[slot].tag != tag || !(distributions_[slots_[slot].distribution].key == key))) {
    slot = (slot + 1) & mask;
  }
  return slot;
}

Distribution& DistributionTable::findOrAdd(const CellKey& key) {
  if (2 * distributions_.size() >= slots_.size()) {
    slots_.assign(2 * slots_.size(), {});
    for (std::size_t i = 0; i < distributions_.size(); ++i) {
      const CellKey& known = distributions_[i].key;
      const std::uint64_t hash = known.hash();
      slots_[slotOf(known, hash)] = {static_cast<std::int32_t>(i), tagOf(hash)};
    }
  }
  const std::uint64_t hash = key.hash();
  Slot& slot = slots_[slotOf(key, hash)];
  if (slot.distribution < 0) {
    slot = {static_cast<std::int32_t>(distributions_.size()), tagOf(hash)};
    distributions_.emplace_back();
    distributions_.back().key = key;
  }
  return distributions_[slot.distribution];
}

void DistributionTable::mark(std::uint32_t fewest_points) {
  marks_.assign((1u << 17) / 64, 0);
  for (const Distribution& d : distributions_) {
    if (d.points < fewest_points) continue;
    const std::uint32_t bit = bitOf(d.key);
    marks_[bit >> 6] |= std::uint64_t{1} << (bit & 63);
  }
}

const Distribution* DistributionTable::find(const CellKey& key) const {
  const std::int32_t i = slots_[slotOf(key, key.hash())].distribution;
  return i < 0 ? nullptr : &distributions_[i];
}

}  // namespace xview
