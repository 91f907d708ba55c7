#include "common/core/file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "common/core/error.h"

namespace periplus {

std::string read_file(const std::string& path, std::uint64_t most_bytes) {
  const auto refuse = [&] { throw_error(ErrorCode::io, "cannot read " + path + ": " + std::strerror(errno)); };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) refuse();
  std::string bytes;
  char block[65536];
  for (std::size_t n; (n = std::fread(block, 1, sizeof block, file.get())) > 0;) {
    bytes.append(block, n);
    require(bytes.size() <= most_bytes, ErrorCode::bad_size, path + " is longer than " + std::to_string(most_bytes) + " bytes, too large to be read");
  }
  if (std::ferror(file.get())) refuse();
  return bytes;
}

}  // namespace periplus
