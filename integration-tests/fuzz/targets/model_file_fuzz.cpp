// Model files. The checksum in the header would keep nearly every mutation from what it protects: each input is read as it is,
// and again with the checksum that its payload has. An input that does not begin with a version's line is a payload alone.
#include "common/core/hash.h"
#include "common/object_model/model_file.h"
#include "integration-tests/fuzz/expected_refusal.h"

using namespace periplus;

namespace {

constexpr std::string_view kBegin = "PERIPLUS-MODEL ";
constexpr std::size_t kChecksum = 65;  // 64 digits and the end of the line

const std::string& newest_line() {
  static const std::string line = [] {
    object_model::ObjectBox box;
    box.size = {0.02, 0.02, 0.02};
    const std::string file = object_model::write_model(object_model::ObjectModel("x", box, 0.02, {}));
    return file.substr(0, file.find('\n') + 1);
  }();
  return line;
}

std::string with_right_checksum(std::string_view file) {
  std::string line = newest_line();
  if (file.starts_with(kBegin)) {
    const std::size_t end = file.find('\n');
    if (end != std::string_view::npos && end < 64) {
      line = file.substr(0, end + 1);
      file.remove_prefix(end + 1);
      file.remove_prefix(std::min(kChecksum, file.size()));
    }
  }
  return line + sha256_hex(file) + "\n" + std::string(file);
}

void read(std::string_view file) {
  const auto model = fuzz::result_or_refusal([&] { return object_model::read_model(file); });
  if (!model) return;
  const std::string written = object_model::write_model(*model);
  const auto again = fuzz::must_read("a model was read and written", [&] { return object_model::read_model(written); });
  if (object_model::write_model(again) != written) fuzz::finding("a model that was read and written is not the same the second time");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view file = fuzz::text(data, size);
  read(file);
  read(with_right_checksum(file));
  return 0;
}
