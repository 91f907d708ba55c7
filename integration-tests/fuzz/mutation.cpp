#include "integration-tests/fuzz/mutation.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace periplus::fuzz {
namespace {

constexpr std::array<std::string_view, 14> kExtremes{"0", "-1", "1e308", "-1e308", "1e-320", "nan", ".inf", "4294967296", "18446744073709551616", "2147483648", "", "~", "[]", "{}"};
constexpr std::size_t kLongest = 1u << 20;

bool of_a_number(char c) { return std::isdigit(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '+' || c == 'e'; }

void change_number(std::string& text, Random& random) {
  std::size_t begin = random.below(text.size());
  while (begin < text.size() && !std::isdigit(static_cast<unsigned char>(text[begin]))) ++begin;
  if (begin == text.size()) return;
  while (begin > 0 && of_a_number(text[begin - 1])) --begin;
  std::size_t end = begin;
  while (end < text.size() && of_a_number(text[end])) ++end;
  text.replace(begin, end - begin, kExtremes[random.below(kExtremes.size())]);
}

void change(std::string& text, std::string_view other, Random& random) {
  if (text.empty()) text = other;
  if (text.empty()) return;
  const std::size_t at = random.below(text.size());
  const std::size_t length = 1 + random.below(std::min<std::size_t>(64, text.size() - at));
  switch (random.below(9)) {
    case 0: text[at] = static_cast<char>(text[at] ^ (1 << random.below(8))); break;
    case 1: text[at] = static_cast<char>(random.below(256)); break;
    case 2: std::fill_n(text.begin() + static_cast<std::ptrdiff_t>(at), std::min<std::size_t>(4, text.size() - at), random.below(2) ? '\xff' : '\0'); break;
    case 3: text.erase(at, length); break;
    case 4: text.insert(at, text.substr(at, length)); break;
    case 5: text.resize(at); break;
    case 6: text.insert(at, 1 + random.below(300), text[at]); break;
    case 7:
      if (!other.empty()) text.insert(at, other.substr(random.below(other.size()), 1 + random.below(128)));
      break;
    default: change_number(text, random);
  }
  text.resize(std::min(text.size(), kLongest));
}

}  // namespace

std::string mutated(std::string_view input, std::string_view other, Random& random) {
  std::string text(input);
  for (std::uint64_t n = 1 + random.below(4); n > 0; --n) change(text, other, random);
  return text;
}

}  // namespace periplus::fuzz
