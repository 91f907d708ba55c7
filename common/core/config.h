// Typed configuration from YAML. Every key must be one that the program knows; an unknown key is an error that names the
// nearest known one. Units stand in the key's name (least_distance_m, period_s).
//
//   struct Settings { int count = 3; double range_m = 2.5; };
//   config::Node root = config::load_file("nbv_planner.yaml");        // or parse(text, name)
//   Settings s;
//   root.read("count", s.count, {.minimum = 1});                      // keeps the default if the key is absent
//   root.read("range_m", s.range_m, {.minimum = 0});
//   config::Node camera = root.child("camera");                       // an empty node if absent
//   root.finish();                                                    // throws if a key was never asked for
//
// Errors are Error(bad_input) with "<file>:<line>: <dotted.key>: <what is wrong and what is expected>".
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace periplus::config {

struct Range {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
};

class Node {
 public:
  Node();  // an empty mapping
  ~Node();
  Node(const Node&);
  Node& operator=(const Node&);

  bool has(std::string_view key) const;
  // "<file>:<line>: <dotted key>", for errors of one's own.
  std::string where() const;

  // Each reads `key` into `value` and returns true; absent, it leaves the value and returns false. Numbers must be finite.
  bool read(std::string_view key, bool& value) const;
  bool read(std::string_view key, int& value, Range range = {}) const;
  bool read(std::string_view key, std::uint64_t& value) const;
  bool read(std::string_view key, double& value, Range range = {}) const;
  bool read(std::string_view key, std::string& value) const;
  bool read(std::string_view key, Eigen::Vector2d& value) const;
  bool read(std::string_view key, Eigen::Vector3d& value) const;
  bool read(std::string_view key, std::vector<double>& value) const;
  bool read(std::string_view key, std::vector<std::string>& value) const;
  // One of `choices`.
  bool read_choice(std::string_view key, std::string& value, const std::vector<std::string>& choices) const;

  // As read(), but an absent key is an error.
  template <class T>
  T get(std::string_view key) const {
    T value{};
    if (!read(key, value)) missing(key);
    return value;
  }

  // Mapping below `key`; an empty node if absent.
  Node child(std::string_view key) const;
  // Elements of the sequence below `key` (mappings); empty if absent.
  std::vector<Node> children(std::string_view key) const;
  // Keys of this mapping in file order; marks them all as known.
  std::vector<std::string> keys() const;

  // Throws Error(bad_input) for any key of this node, or of a node taken from it, that was never read.
  void finish() const;

  // This node as YAML text.
  std::string text() const;

 private:
  friend Node parse(std::string_view, std::string_view);
  friend void set(Node&, std::string_view, std::string_view);
  friend void overlay(Node&, const Node&);
  [[noreturn]] void missing(std::string_view key) const;
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

// `name` stands in error messages. Throws Error(bad_input) for text that is not YAML, anchors and aliases included.
Node parse(std::string_view text, std::string_view name);
// Throws Error(io) if the file cannot be read; files over 4 MiB are refused.
Node load_file(const std::string& path);
// Sets `dotted.key` to a YAML scalar (or a flow list, "[1, 2]"), creating mappings on the way: command-line overrides.
void set(Node& root, std::string_view dotted_key, std::string_view scalar);
// Lays `over` on `base`: mappings are joined key by key, everything else is replaced. Values keep their place for errors.
void overlay(Node& base, const Node& over);

// The word of `known` with the least edit distance to `word`, the first one of equals; empty if there are none, or if
// `word` is longer than 256 characters (comparing long ones takes quadratic time).
std::string nearest(std::string_view word, const std::vector<std::string>& known);

}  // namespace periplus::config
