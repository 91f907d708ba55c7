#include "common/core/config.h"

#include <yaml-cpp/emitter.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <string_view>
#include <system_error>

#include "common/core/error.h"
#include "common/core/utf8.h"

namespace periplus::config {
namespace {

constexpr std::size_t kLongestText = 4u << 20;
constexpr std::size_t kDeepest = 64;
constexpr std::size_t kLongestKey = 256;
constexpr std::size_t kMostKeys = 1024;  // of a mapping, whose keys are looked for one after the other

}  // namespace

// A value of the document with its place; a mapping also knows which of its keys were asked for.
struct Node::Impl {
  enum class Kind { null, scalar, sequence, mapping };
  Kind kind = Kind::mapping;
  bool plain = false;                                  // of a scalar: written without quotes
  std::string scalar;
  std::vector<std::shared_ptr<Impl>> items;            // of a sequence
  std::vector<std::pair<std::string, std::shared_ptr<Impl>>> entries;  // of a mapping, in file order
  std::shared_ptr<const std::string> source = std::make_shared<const std::string>("configuration");
  int line = 0;                                        // from 1; 0: not from a file
  std::string path;                                    // dotted
  std::set<std::string, std::less<>> asked;
  bool taken = false;                                  // as a child: finish() looks into it

  std::string where() const {
    std::string text = *source;
    if (line > 0) text += ":" + std::to_string(line);
    if (!path.empty()) text += ": " + path;
    return text;
  }

  const std::shared_ptr<Impl>* find(std::string_view key) const {
    for (const auto& [name, value] : entries)
      if (name == key) return &value;
    return nullptr;
  }

  // Asked for from now on; nullptr if absent.
  Impl* ask(std::string_view key) {
    asked.emplace(key);
    const std::shared_ptr<Impl>* found = find(key);
    return found ? found->get() : nullptr;
  }

  std::string path_of(std::string_view key) const { return path.empty() ? std::string(key) : path + "." + std::string(key); }

  void give_paths(const std::string& own) {
    path = own;
    for (std::size_t i = 0; i < items.size(); ++i) items[i]->give_paths(own + "[" + std::to_string(i) + "]");
    for (auto& [name, value] : entries) value->give_paths(path_of(name));
  }

  void check_asked() const {
    for (const auto& [name, value] : entries) {
      if (!asked.contains(name)) {
        std::string message = value->where() + ": unknown key";
        if (asked.empty()) {
          message += "; no keys are known here, remove it";
        } else {
          message += "; the nearest known one is '" + nearest(name, std::vector<std::string>(asked.begin(), asked.end())) + "'";
        }
        throw Error(ErrorCode::bad_input, message);
      }
      if (value->taken) value->check_asked();
      for (const auto& item : value->items)
        if (item->taken) item->check_asked();
    }
  }

  void emit(YAML::Emitter& out) const {
    switch (kind) {
      case Kind::null: out << YAML::Null; break;
      case Kind::scalar:
        if (plain) {
          out << scalar;
        } else {
          out << YAML::DoubleQuoted << scalar;
        }
        break;
      case Kind::sequence: {
        const bool short_one = std::all_of(items.begin(), items.end(), [](const auto& item) { return item->kind == Kind::scalar; });
        if (short_one) out << YAML::Flow;
        out << YAML::BeginSeq;
        for (const auto& item : items) item->emit(out);
        out << YAML::EndSeq;
        break;
      }
      case Kind::mapping:
        out << YAML::BeginMap;
        for (const auto& [name, value] : entries) {
          out << YAML::Key << name << YAML::Value;
          value->emit(out);
        }
        out << YAML::EndMap;
        break;
    }
  }
};

namespace {

[[noreturn]] void refuse(const std::string& where, const std::string& what) { throw Error(ErrorCode::bad_input, where + ": " + what); }

std::string quoted(const std::string& text) { return "'" + (text.size() > 60 ? text.substr(0, 60) + "…" : text) + "'"; }

// Builds the tree of one document; refuses what a configuration has no use for.
template <class Impl>
class Builder : public YAML::EventHandler {
 public:
  explicit Builder(std::shared_ptr<const std::string> source) : source_(std::move(source)) {}

  std::shared_ptr<Impl> root;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { refuse(place(mark), "aliases (*name) are not allowed; write the value out"); }
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { add(make(mark, "", anchor, Impl::Kind::null)); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, const std::string& text) override {
    if (!stack_.empty() && stack_.back()->kind == Impl::Kind::mapping && !has_key_.back()) {
      if (anchor != 0) refuse(place(mark), "anchors (&name) are not allowed; write the value out where it is used");
      take_key(mark, text);
      return;
    }
    auto value = make(mark, tag, anchor, Impl::Kind::scalar);
    value->scalar = text;
    value->plain = tag == "?" || tag.empty();
    if (value->plain && (text == "~" || text == "null")) value->kind = Impl::Kind::null;
    add(value);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, YAML::EmitterStyle::value) override {
    open(make(mark, tag, anchor, Impl::Kind::sequence), mark);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, YAML::EmitterStyle::value) override {
    open(make(mark, tag, anchor, Impl::Kind::mapping), mark);
  }
  void OnMapEnd() override { close(); }

 private:
  std::string place(const YAML::Mark& mark) const { return *source_ + ":" + std::to_string(mark.line + 1); }

  std::shared_ptr<Impl> make(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, typename Impl::Kind kind) const {
    if (anchor != 0) refuse(place(mark), "anchors (&name) are not allowed; write the value out where it is used");
    if (!tag.empty() && tag != "?" && tag != "!" && !tag.starts_with("tag:yaml.org,2002:"))
      refuse(place(mark), "the tag " + quoted(tag) + " is not allowed; remove it");
    auto value = std::make_shared<Impl>();
    value->kind = kind;
    value->source = source_;
    value->line = mark.line + 1;
    return value;
  }

  void take_key(const YAML::Mark& mark, const std::string& text) {
    if (text.empty() || text.size() > kLongestKey) refuse(place(mark), "a key must have 1 to " + std::to_string(kLongestKey) + " characters");
    if (stack_.back()->entries.size() >= kMostKeys) refuse(place(mark), "a mapping may have at most " + std::to_string(kMostKeys) + " keys");
    if (stack_.back()->find(text)) refuse(place(mark), "the key " + quoted(text) + " stands here twice; keep one");
    keys_.back() = text;
    key_lines_.back() = mark.line + 1;
    has_key_.back() = true;
  }

  void add(const std::shared_ptr<Impl>& value) {
    if (stack_.empty()) {
      root = value;
    } else if (stack_.back()->kind == Impl::Kind::sequence) {
      stack_.back()->items.push_back(value);
    } else {
      if (!has_key_.back()) refuse(value->where(), "a key must be a plain text");
      value->line = key_lines_.back();  // an error is looked for at its key, though its value may begin a line below
      stack_.back()->entries.emplace_back(keys_.back(), value);
      has_key_.back() = false;
    }
  }

  void open(const std::shared_ptr<Impl>& value, const YAML::Mark& mark) {
    if (stack_.size() >= kDeepest) refuse(place(mark), "nested more than " + std::to_string(kDeepest) + " deep");
    add(value);
    stack_.push_back(value);
    keys_.emplace_back();
    key_lines_.push_back(0);
    has_key_.push_back(false);
  }

  void close() {
    stack_.pop_back();
    keys_.pop_back();
    key_lines_.pop_back();
    has_key_.pop_back();
  }

  std::shared_ptr<const std::string> source_;
  std::vector<std::shared_ptr<Impl>> stack_;
  std::vector<std::string> keys_;
  std::vector<int> key_lines_;
  std::vector<bool> has_key_;
};

template <class Impl>
std::shared_ptr<Impl> parse_value(std::string_view text, std::string_view name) {
  const auto source = std::make_shared<const std::string>(name);
  if (text.size() > kLongestText)
    refuse(*source, std::to_string(text.size()) + " bytes; at most " + std::to_string(kLongestText) + " are read");
  // What is not would be read as other characters, and a path would not come back as it was.
  if (const std::size_t at = first_not_utf8(text); at != std::string_view::npos)
    refuse(*source + ":" + std::to_string(1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n')), "is not UTF-8; write it in that encoding");
  std::istringstream in{std::string(text)};
  Builder<Impl> builder(source);
  try {
    YAML::Parser parser(in);
    parser.HandleNextDocument(builder);
    Builder<Impl> second(source);
    if (parser.HandleNextDocument(second)) refuse(*source, "holds more than one YAML document; keep one");
  } catch (const YAML::Exception& e) {
    refuse(*source + ":" + std::to_string(e.mark.line + 1), "not YAML: " + e.msg);
  }
  return builder.root;
}

template <class Impl>
const std::string& scalar_of(const Impl& value, const std::string& expected) {
  if (value.kind != Impl::Kind::scalar) refuse(value.where(), (value.kind == Impl::Kind::null ? "has no value; expected " : "expected ") + expected);
  return value.scalar;
}

template <class Impl>
double number_of(const Impl& value, const std::string& expected) {
  const std::string& text = scalar_of(value, expected);
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double number = 0;
  const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (!value.plain || problem != std::errc() || end != digits.data() + digits.size() || !std::isfinite(number))
    refuse(value.where(), "expected " + expected + ", found " + quoted(text));
  return number;
}

template <class Impl, class Integer>
Integer integer_of(const Impl& value, const std::string& expected) {
  const std::string& text = scalar_of(value, expected);
  Integer number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (!value.plain || problem != std::errc() || end != text.data() + text.size())
    refuse(value.where(), "expected " + expected + ", found " + quoted(text));
  return number;
}

std::string number_text(double x) {
  char buffer[32];
  const auto [end, problem] = std::to_chars(buffer, buffer + sizeof buffer, x);
  return problem == std::errc() ? std::string(buffer, end) : std::to_string(x);
}

std::string in_range(const Range& range) {
  const bool low = std::isfinite(range.minimum), high = std::isfinite(range.maximum);
  if (low && high) return " from " + number_text(range.minimum) + " to " + number_text(range.maximum);
  if (low) return " of at least " + number_text(range.minimum);
  if (high) return " of at most " + number_text(range.maximum);
  return "";
}

template <class Impl>
void check_range(const Impl& value, double number, const Range& range, const std::string& expected) {
  if (!(number >= range.minimum && number <= range.maximum)) refuse(value.where(), "expected " + expected + ", found " + number_text(number));
}

template <class Impl>
const std::vector<std::shared_ptr<Impl>>& sequence_of(const Impl& value, const std::string& expected) {
  if (value.kind != Impl::Kind::sequence) refuse(value.where(), "expected " + expected);
  return value.items;
}

template <class Vector, class Impl>
void read_vector(const Impl& value, Vector& vector, int size) {
  const std::string expected = "a list of " + std::to_string(size) + " finite numbers";
  const auto& items = sequence_of(value, expected);
  if (items.size() != static_cast<std::size_t>(size)) refuse(value.where(), "expected " + expected + ", found " + std::to_string(items.size()));
  for (int i = 0; i < size; ++i) vector[i] = number_of(*items[static_cast<std::size_t>(i)], "a finite number");
}

// Optimal string alignment distance: insertions, deletions, substitutions and swaps of neighbours.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

}  // namespace

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  if (word.size() > 256) return {};
  std::string best;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

Node::Node() : impl_(std::make_shared<Impl>()) {}
Node::~Node() = default;
Node::Node(const Node&) = default;
Node& Node::operator=(const Node&) = default;

bool Node::has(std::string_view key) const { return impl_->find(key) != nullptr; }
std::string Node::where() const { return impl_->where(); }

bool Node::read(std::string_view key, bool& value) const {
  const Impl* found = impl_->ask(key);
  if (!found) return false;
  const std::string& text = scalar_of(*found, "true or false");
  if (!found->plain || (text != "true" && text != "false")) refuse(found->where(), "expected true or false, found " + quoted(text));
  value = text == "true";
  return true;
}

bool Node::read(std::string_view key, int& value, Range range) const {
  const Impl* found = impl_->ask(key);
  if (!found) return false;
  const std::string expected = "a whole number" + in_range(range);
  const int number = integer_of<Impl, int>(*found, expected);
  check_range(*found, number, range, expected);
  value = number;
  return true;
}

bool Node::read(std::string_view key, std::uint64_t& value) const {
  const Impl* found = impl_->ask(key);
  if (!found) return false;
  value = integer_of<Impl, std::uint64_t>(*found, "a whole number from 0 to 18446744073709551615");
  return true;
}

bool Node::read(std::string_view key, double& value, Range range) const {
  const Impl* found = impl_->ask(key);
  if (!found) return false;
  const std::string expected = "a finite number" + in_range(range);
  const double number = number_of(*found, expected);
  check_range(*found, number, range, expected);
  value = number;
  return true;
}

bool Node::read(std::string_view key, std::string& value) const {
  const Impl* found = impl_->ask(key);
  if (!found) return false;
  value = scalar_of(*found, "a text");
  return true;
}

bool Node::read(std::string_view key, Eigen::Vector2d& value) const {
  const Impl* found = impl_->ask(key);
  if (!found) return false;
  read_vector(*found, value, 2);
  return true;
}

bool Node::read(std::string_view key, Eigen::Vector3d& value) const {
  const Impl* found = impl_->ask(key);
  if (!found) return false;
  read_vector(*found, value, 3);
  return true;
}

bool Node::read(std::string_view key, std::vector<double>& value) const {
  const Impl* found = impl_->ask(key);
  if (!found) return false;
  std::vector<double> numbers;
  for (const auto& item : sequence_of(*found, "a list of finite numbers")) numbers.push_back(number_of(*item, "a finite number"));
  value = std::move(numbers);
  return true;
}

bool Node::read(std::string_view key, std::vector<std::string>& value) const {
  const Impl* found = impl_->ask(key);
  if (!found) return false;
  std::vector<std::string> texts;
  for (const auto& item : sequence_of(*found, "a list of texts")) texts.push_back(scalar_of(*item, "a text"));
  value = std::move(texts);
  return true;
}

bool Node::read_choice(std::string_view key, std::string& value, const std::vector<std::string>& choices) const {
  std::string text;
  if (!read(key, text)) return false;
  if (std::find(choices.begin(), choices.end(), text) == choices.end()) {
    std::string all;
    for (const std::string& choice : choices) all += (all.empty() ? "" : ", ") + choice;
    refuse((*impl_->find(key))->where(), "expected one of " + all + "; found " + quoted(text));
  }
  value = text;
  return true;
}

Node Node::child(std::string_view key) const {
  impl_->asked.emplace(key);
  Node node;
  const std::shared_ptr<Impl>* found = impl_->find(key);
  if (!found || (*found)->kind == Impl::Kind::null) {
    node.impl_->source = impl_->source;
    node.impl_->line = found ? (*found)->line : impl_->line;
    node.impl_->path = impl_->path_of(key);
    return node;
  }
  if ((*found)->kind != Impl::Kind::mapping) refuse((*found)->where(), "expected a mapping (key: value)");
  (*found)->taken = true;
  node.impl_ = *found;
  return node;
}

std::vector<Node> Node::children(std::string_view key) const {
  std::vector<Node> nodes;
  const Impl* found = impl_->ask(key);
  if (!found || found->kind == Impl::Kind::null) return nodes;
  for (const auto& item : sequence_of(*found, "a list of mappings")) {
    if (item->kind != Impl::Kind::mapping) refuse(item->where(), "expected a mapping (key: value)");
    item->taken = true;
    nodes.emplace_back();
    nodes.back().impl_ = item;
  }
  return nodes;
}

std::vector<std::string> Node::keys() const {
  std::vector<std::string> names;
  for (const auto& [name, value] : impl_->entries) {
    names.push_back(name);
    impl_->asked.insert(name);
  }
  return names;
}

void Node::finish() const { impl_->check_asked(); }

std::string Node::text() const {
  YAML::Emitter out;
  out.SetIndent(2);
  impl_->emit(out);
  return std::string(out.c_str()) + "\n";
}

void Node::missing(std::string_view key) const {
  refuse(impl_->where(), (impl_->path.empty() ? "the key '" : "the key '" + impl_->path + ".") + std::string(key) + "' is missing; add it");
}

Node parse(std::string_view text, std::string_view name) {
  Node node;
  auto root = parse_value<Node::Impl>(text, name);
  if (root && root->kind != Node::Impl::Kind::null) {
    if (root->kind != Node::Impl::Kind::mapping) refuse(root->where(), "expected a mapping (key: value) as the whole document");
    node.impl_ = std::move(root);
    node.impl_->give_paths("");
  } else {
    node.impl_->source = std::make_shared<const std::string>(name);
  }
  node.impl_->line = 0;
  return node;
}

Node load_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  // Reading tells a folder from a file, which opening does not.
  if (!in || in.peek() == std::ifstream::traits_type::eof()) {
    if (!in.is_open() || in.bad() || !in.eof()) throw Error(ErrorCode::io, "cannot read " + path + "; check its name and permissions");
  }
  in.clear();
  std::string text(kLongestText + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad()) throw Error(ErrorCode::io, "cannot read " + path + "; check its name and permissions");
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kLongestText) refuse(path, "is larger than " + std::to_string(kLongestText) + " bytes; that is no configuration");
  return parse(text, path);
}

void set(Node& root, std::string_view dotted_key, std::string_view scalar) {
  const std::string source = "command line";
  std::string_view rest = dotted_key;
  Node::Impl* at = root.impl_.get();
  while (true) {
    const std::size_t dot = rest.find('.');
    const std::string name(rest.substr(0, dot));
    if (name.empty()) refuse(source, quoted(std::string(dotted_key)) + " is no key; write section.key=value");
    const std::shared_ptr<Node::Impl>* found = at->find(name);
    if (dot == std::string_view::npos) {
      auto value = parse_value<Node::Impl>(scalar, source);
      if (!value) {
        value = std::make_shared<Node::Impl>();
        value->kind = Node::Impl::Kind::null;
        value->source = std::make_shared<const std::string>(source);
      }
      value->line = 0;
      value->give_paths(at->path_of(name));
      if (found) {
        *std::find_if(at->entries.begin(), at->entries.end(), [&](const auto& entry) { return entry.first == name; }) = {name, value};
      } else {
        at->entries.emplace_back(name, value);
      }
      return;
    }
    if (!found || (*found)->kind == Node::Impl::Kind::null) {
      auto mapping = std::make_shared<Node::Impl>();
      mapping->source = std::make_shared<const std::string>(source);
      mapping->path = at->path_of(name);
      std::erase_if(at->entries, [&](const auto& entry) { return entry.first == name; });
      at->entries.emplace_back(name, mapping);
      at = mapping.get();
    } else {
      if ((*found)->kind != Node::Impl::Kind::mapping) refuse((*found)->where(), "has no keys below it, so " + quoted(std::string(dotted_key)) + " cannot be set");
      at = found->get();
    }
    rest.remove_prefix(dot + 1);
  }
}

void overlay(Node& base, const Node& over) {
  const auto merge = [](const auto& self, Node::Impl& to, const Node::Impl& from) -> void {
    for (const auto& [name, value] : from.entries) {
      const auto at = std::find_if(to.entries.begin(), to.entries.end(), [&, &key = name](const auto& entry) { return entry.first == key; });
      if (at == to.entries.end()) {
        to.entries.emplace_back(name, value);
      } else if (at->second->kind == Node::Impl::Kind::mapping && value->kind == Node::Impl::Kind::mapping) {
        self(self, *at->second, *value);
      } else {
        at->second = value;
      }
    }
  };
  merge(merge, *base.impl_, *over.impl_);
}

}  // namespace periplus::config
