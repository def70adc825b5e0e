// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "xview/base/error.h"

namespace xview {

// What one process tells another on a machine of the same kind: numbers as they are in memory. A
// struct of more than numbers has beside it
//
//   template <class Message> void visit(Foo& foo, Message& message) { message(foo.a, foo.b); }
//
// which writes and reads it.

template <class Value>
constexpr bool isPlain() {
  if constexpr (std::is_base_of_v<Eigen::MatrixBase<Value>, Value>)
    return Value::SizeAtCompileTime != Eigen::Dynamic;
  else
    return std::is_trivially_copyable_v<Value>;
}

class MessageWriter {
 public:
  template <class... Values>
  MessageWriter& operator()(const Values&... values) {
    (put(values), ...);
    return *this;
  }
  std::string take() { return std::move(text_); }

 private:
  void add(const void* bytes, std::size_t count) {
    text_.append(static_cast<const char*>(bytes), count);
  }
  template <class Value>
  void put(const Value& value) {
    if constexpr (isPlain<Value>())
      add(&value, sizeof value);
    else
      visit(const_cast<Value&>(value), *this);  // which does not change it
  }
  void put(const Eigen::Isometry3d& pose) { put(pose.matrix()); }
  template <class A, class B>
  void put(const std::pair<A, B>& pair) {
    (*this)(pair.first, pair.second);
  }
  void put(const std::string& text) {
    put(text.size());
    add(text.data(), text.size());
  }
  template <class Value, class Allocator>
  void put(const std::vector<Value, Allocator>& values) {
    put(values.size());
    if constexpr (isPlain<Value>() && !std::is_same_v<Value, bool>) {
      add(values.data(), values.size() * sizeof(Value));
    } else {
      for (const Value& value : values) put(value);
    }
  }
  template <class Key, class Value>
  void put(const std::map<Key, Value>& values) {
    put(values.size());
    for (const auto& entry : values) put(entry);
  }

  std::string text_;
};

/// Throws Error if the text is not what a MessageWriter wrote of such values.
class MessageReader {
 public:
  explicit MessageReader(const std::string& text) : text_(text) {}
  template <class... Values>
  MessageReader& operator()(Values&... values) {
    (get(values), ...);
    return *this;
  }
  /// The next value.
  template <class Value>
  Value next() {
    Value value{};
    get(value);
    return value;
  }
  /// Nothing is left of it.
  void end() const {
    if (place_ != text_.size()) fail();
  }
  [[noreturn]] static void fail() {
    throw Error("message between processes", "not what this version of xview sends");
  }

 private:
  void take(void* to, std::size_t count) {
    if (count > text_.size() - place_) fail();
    if (count > 0) std::memcpy(to, text_.data() + place_, count);
    place_ += count;
  }
  /// Of values that take at least `bytes` bytes each.
  std::size_t count(std::size_t bytes) {
    const auto values = next<std::size_t>();
    if (values > (text_.size() - place_) / bytes) fail();
    return values;
  }
  template <class Value>
  void get(Value& value) {
    if constexpr (isPlain<Value>())
      take(static_cast<void*>(&value), sizeof value);
    else
      visit(value, *this);
  }
  void get(Eigen::Isometry3d& pose) { get(pose.matrix()); }
  template <class A, class B>
  void get(std::pair<A, B>& pair) {
    (*this)(pair.first, pair.second);
  }
  void get(std::string& text) {
    text.resize(count(1));
    take(text.data(), text.size());
  }
  template <class Value, class Allocator>
  void get(std::vector<Value, Allocator>& values) {
    if constexpr (std::is_same_v<Value, bool>) {
      values.resize(count(1));
      for (auto&& value : values) value = next<bool>();
    } else if constexpr (isPlain<Value>()) {
      values.resize(count(sizeof(Value)));
      take(static_cast<void*>(values.data()), values.size() * sizeof(Value));
    } else {
      values.resize(count(1));
      for (Value& value : values) get(value);
    }
  }
  template <class Key, class Value>
  void get(std::map<Key, Value>& values) {
    for (auto left = count(1); left > 0; --left) values.insert(next<std::pair<Key, Value>>());
  }

  const std::string& text_;
  std::size_t place_ = 0;
};

}  // namespace xview
