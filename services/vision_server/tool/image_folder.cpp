#include "services/vision_server/tool/image_folder.h"

#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <string_view>

#include "common/core/file.h"
#include "services/vision_server/calibration.h"

namespace periplus::vision {
namespace {

namespace fs = std::filesystem;

constexpr long kLargestSide = 8192;

struct Size {
  long width, height;
};

unsigned byte(std::string_view b, std::size_t i) { return static_cast<unsigned char>(b[i]); }
long big_endian(std::string_view b, std::size_t at, int bytes) {
  long value = 0;
  for (int i = 0; i < bytes; ++i) value = value * 256 + static_cast<long>(byte(b, at + static_cast<std::size_t>(i)));
  return value;
}

constexpr const char* kCutShort = "the file is cut short; copy it again";

// A start of frame says the size; the other segments before the first scan are stepped over, previews in them too. From the scan on only
// the end of the image is 0xffd9, whatever a camera put behind it.
std::optional<Size> jpeg_size(std::string_view b) {
  std::optional<Size> size;
  std::size_t at = 2;
  while (at + 4 <= b.size()) {
    if (byte(b, at) != 0xff) return std::nullopt;
    const unsigned marker = byte(b, at + 1);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc && at + 9 <= b.size()) size = Size{big_endian(b, at + 7, 2), big_endian(b, at + 5, 2)};
    if (marker == 0xda) {
      require(b.find("\xff\xd9", at) != std::string_view::npos, ErrorCode::bad_input, kCutShort);
      return size;
    }
    at += 2 + static_cast<std::size_t>(big_endian(b, at + 2, 2));
  }
  throw_error(ErrorCode::bad_input, kCutShort);
}

std::optional<Size> pnm_size(std::string_view b) {
  long numbers[2] = {0, 0};
  std::size_t at = 2;
  for (long& n : numbers) {
    while (at < b.size() && (std::isspace(static_cast<unsigned char>(b[at])) || b[at] == '#'))
      at = b[at] == '#' ? std::min(b.find('\n', at), b.size()) : at + 1;
    for (; at < b.size() && std::isdigit(static_cast<unsigned char>(b[at])) && n <= kLargestSide; ++at) n = n * 10 + (b[at] - '0');
  }
  return Size{numbers[0], numbers[1]};
}

// What the header promises, without decoding; nothing for another format.
std::optional<Size> promised_size(std::string_view b) {
  if (b.size() > 32 && b.starts_with("\x89PNG\r\n\x1a\n")) {
    const std::string_view end = b.substr(b.size() - std::min<std::size_t>(b.size(), 4096));
    require(end.find("IEND") != std::string_view::npos, ErrorCode::bad_input, kCutShort);
    return Size{big_endian(b, 16, 4), big_endian(b, 20, 4)};
  }
  if (b.starts_with("\xff\xd8\xff")) return jpeg_size(b);
  if (b.size() > 32 && b.starts_with("BM")) {
    const auto little = [&](std::size_t at) { return static_cast<long>(byte(b, at) | byte(b, at + 1) << 8 | byte(b, at + 2) << 16) + (byte(b, at + 3) ? kLargestSide + 1 : 0); };
    // A negative height: rows from the top.
    const bool from_top = byte(b, 25) == 0xff;
    const long below_zero = 0x1000000 - static_cast<long>(byte(b, 22) | byte(b, 23) << 8 | byte(b, 24) << 16);
    return Size{little(18), from_top ? below_zero : little(22)};
  }
  if (b.size() > 8 && b[0] == 'P' && b[1] >= '2' && b[1] <= '6' && b[1] != '4') return pnm_size(b);
  return std::nullopt;
}

bool is_image_name(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  static const std::set<std::string> endings{".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".pnm"};
  return endings.contains(ending);
}

// The last number in a file's name without leading zeros; the name where there is none.
std::string number_of(const std::string& name) {
  const std::string stem = fs::path(name).stem().string();
  const std::size_t last = stem.find_last_of("0123456789");
  if (last == std::string::npos) return stem;
  std::size_t first = last;
  while (first > 0 && std::isdigit(static_cast<unsigned char>(stem[first - 1]))) --first;
  while (first < last && stem[first] == '0') ++first;
  return stem.substr(first, last - first + 1);
}

}  // namespace

std::vector<ImageFile> images_of(const std::string& where) {
  const fs::path given(where);
  const std::string last = given.filename().string();
  std::error_code problem;
  const bool pattern = last.find_first_of("*?[") != std::string::npos && !fs::is_directory(given, problem);
  const fs::path folder = pattern ? (given.has_parent_path() ? given.parent_path() : fs::path(".")) : given;
  require(fs::is_directory(folder, problem), ErrorCode::bad_input, folder.string() + ": there is no such folder; name a folder of images, or a pattern such as 'data/left*.jpg'");
  std::vector<ImageFile> out;
  fs::directory_iterator files(folder, problem);
  require(!problem, ErrorCode::io, "cannot read the folder " + folder.string() + ": " + problem.message());
  for (const fs::directory_entry& entry : files) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file(problem) || !(pattern ? ::fnmatch(last.c_str(), name.c_str(), FNM_PERIOD) == 0 : is_image_name(entry.path()))) continue;
    out.push_back({name, entry.path().string()});
    require(out.size() <= 500, ErrorCode::bad_input, where + ": more than 500 images; choose 15 to 50 with the board tilted each way");
  }
  require(!out.empty(), ErrorCode::bad_input, where + ": no images; PNG, JPEG, BMP and PNM files are read");
  std::sort(out.begin(), out.end(), [](const ImageFile& a, const ImageFile& b) { return a.name < b.name; });
  return out;
}

std::vector<std::pair<ImageFile, ImageFile>> paired(const std::vector<ImageFile>& left, const std::vector<ImageFile>& right) {
  std::set<std::string> right_names;
  for (const ImageFile& r : right) right_names.insert(r.name);
  const bool by_name = std::all_of(left.begin(), left.end(), [&](const ImageFile& l) { return right_names.contains(l.name); });
  std::vector<ViewFault> faults;
  const auto by_key = [&](const std::vector<ImageFile>& images) {
    std::map<std::string, ImageFile> out;
    for (const ImageFile& i : images)
      if (const auto [known, added] = out.emplace(by_name ? i.name : number_of(i.name), i); !added)
        faults.push_back({i.name, "carries the same number as " + known->second.name + "; a pair is told by the last number in its names"});
    return out;
  };
  const auto lefts = by_key(left), rights = by_key(right);
  std::vector<std::pair<ImageFile, ImageFile>> out;
  for (const ImageFile& l : left) {
    const std::string key = by_name ? l.name : number_of(l.name);
    if (const auto r = rights.find(key); r != rights.end()) out.emplace_back(l, r->second);
    else faults.push_back({l.name, "has no partner on the right (number " + key + "); take it out, or add the right image"});
  }
  for (const auto& [key, r] : rights)
    if (!lefts.contains(key)) faults.push_back({r.name, "has no partner on the left (number " + key + "); take it out, or add the left image"});
  if (!faults.empty()) throw BadViews(std::move(faults));
  return out;
}

ImageU8 load_grey(const std::string& path) {
  const std::string bytes = read_file(path, std::uint64_t{256} << 20);
  require(!bytes.empty(), ErrorCode::bad_input, "the file is empty; copy it again");
  const std::optional<Size> size = promised_size(bytes);
  require(size.has_value(), ErrorCode::bad_input, "no image that can be read: PNG, JPEG, BMP or PNM is expected");
  require(size->width >= 1 && size->height >= 1 && size->width <= kLargestSide && size->height <= kLargestSide, ErrorCode::bad_input,
          "an image of " + std::to_string(size->width) + " x " + std::to_string(size->height) + " pixels: 1 to 8192 a side are read");
  cv::Mat image;
  try {
    image = cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data())), cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
  }
  require(!image.empty() && image.cols == size->width && image.rows == size->height, ErrorCode::bad_input, "the image is damaged; copy it again");
  ImageU8 out(image.cols, image.rows);
  image.copyTo(cv::Mat(image.rows, image.cols, CV_8U, out.data.data()));
  return out;
}

}  // namespace periplus::vision
