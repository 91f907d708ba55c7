#include "services/vision_server/tool/image_folder.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "common/core/file.h"
#include "services/vision_server/calibration.h"

namespace periplus::vision {
namespace {

class ImageFolder : public ::testing::Test {
 protected:
  ImageFolder() : folder_(std::filesystem::temp_directory_path() / ("periplus_image_folder_test_" + std::to_string(::getpid()))) { std::filesystem::create_directories(folder_); }
  ~ImageFolder() override { std::filesystem::remove_all(folder_); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(file(name), std::ios::binary) << bytes;
    return file(name);
  }
  // An image of noise, which does not compress.
  std::string encoded(const std::string& ending, int width = 120, int height = 90) const {
    cv::Mat m(height, width, CV_8U);
    cv::randu(m, 0, 255);
    std::vector<std::uint8_t> out;
    cv::imencode(ending, m, out);
    return {out.begin(), out.end()};
  }
  static std::string refusal(const std::function<void()>& work) {
    try {
      work();
    } catch (const Error& e) {
      return e.what();
    }
    return "not refused";
  }
  std::filesystem::path folder_;
};

std::vector<ImageFile> named(const std::vector<std::string>& names) {
  std::vector<ImageFile> out;
  for (const std::string& n : names) out.push_back({n, n});
  return out;
}

TEST_F(ImageFolder, ReadsWhatItNames) {
  for (const char* ending : {".png", ".jpg", ".bmp", ".pgm"}) {
    const ImageU8 image = load_grey(write(std::string("a") + ending, encoded(ending)));
    EXPECT_EQ(image.width, 120) << ending;
    EXPECT_EQ(image.height, 90) << ending;
    EXPECT_EQ(image.channels, 1);
  }
}

// Some cameras' programs write the rows of a BMP from the top, and say so by a negative height.
TEST_F(ImageFolder, ReadsABitmapFromTheTop) {
  std::string bmp = encoded(".bmp");
  const std::string negative{static_cast<char>(-90), '\xff', '\xff', '\xff'};
  bmp.replace(22, 4, negative);
  const ImageU8 image = load_grey(write("top.bmp", bmp));
  EXPECT_EQ(image.width, 120);
  EXPECT_EQ(image.height, 90);
}

// Phones put a film behind a picture, and previews that end like a picture before it.
TEST_F(ImageFolder, ReadsAJpegWithMoreBehindAndBeforeIt) {
  const std::string jpg = encoded(".jpg");
  EXPECT_EQ(load_grey(write("film.jpg", jpg + std::string(100000, 'f'))).width, 120);
  const std::string preview = encoded(".jpg", 16, 16), length{static_cast<char>((preview.size() + 2) >> 8), static_cast<char>((preview.size() + 2) & 0xff)};
  const std::string with = jpg.substr(0, 2) + "\xff\xe1" + length + preview + jpg.substr(2);
  EXPECT_EQ(load_grey(write("preview.jpg", with)).width, 120);
  const std::string why = refusal([&] { load_grey(write("cut.jpg", with.substr(0, preview.size() + 1500))); });
  EXPECT_NE(why.find("cut short"), std::string::npos) << why;
}

TEST_F(ImageFolder, EveryFileIsHostileUntilChecked) {
  const std::string png = encoded(".png"), jpg = encoded(".jpg");
  std::string huge = png, wrong = png;
  huge[16] = 0x7f;                                             // 2 thousand million columns
  for (std::size_t i = 60; i < 400; ++i) wrong[i] = '\x55';     // damaged within
  const std::pair<std::string, std::string> files[] = {
      {"", "empty"}, {"I am a text, not a picture, whatever my name says.", "no image"}, {huge, "8192"}, {wrong, "damaged"},
      {png.substr(0, png.size() / 2), "cut short"}, {jpg.substr(0, jpg.size() / 2), "cut short"}, {png.substr(0, 20), "no image"}, {"\xff\xd8\xff", "cut short"},
      {"P5\n100000 100000\n255\n", "8192"}, {"P5 # only a comment", "0 x 0"}, {"BM", "no image"}, {std::string("\xff\xd8\xff\xe0\x00\x00\xff\xd9", 8), "no image"}};
  for (const auto& [bytes, says] : files) {
    const std::string path = write("hostile.png", bytes);
    const std::string why = refusal([&] { load_grey(path); });
    EXPECT_NE(why.find(says), std::string::npos) << bytes.substr(0, 30) << ": " << why;
  }
  for (std::size_t length = 0; length < jpg.size(); length += 97) EXPECT_NE(refusal([&] { load_grey(write("cut.jpg", jpg.substr(0, length))); }), "not refused") << length;
  EXPECT_NE(refusal([&] { load_grey(file("none.png")); }), "not refused");
}

TEST_F(ImageFolder, ListsByFolderAndByPattern) {
  for (const char* name : {"left02.jpg", "left01.jpg", "right01.JPG", "left.jpg", "notes.txt", ".left03.jpg"}) write(name, "x");
  std::filesystem::create_directories(folder_ / "left09.jpg");
  const auto names = [](const std::vector<ImageFile>& files) {
    std::string out;
    for (const ImageFile& f : files) out += f.name + " ";
    return out;
  };
  EXPECT_EQ(names(images_of(file("left??.jpg"))), "left01.jpg left02.jpg ");
  EXPECT_NE(names(images_of(folder_.string())).find("right01.JPG"), std::string::npos);
  EXPECT_EQ(names(images_of(folder_.string())).find("notes"), std::string::npos);
  std::filesystem::create_directories(folder_ / "run[1]");
  write("run[1]/a.pnm", "x");
  EXPECT_EQ(names(images_of(file("run[1]"))), "a.pnm ");  // a folder, not a pattern
  EXPECT_NE(refusal([&] { images_of(file("nothing*")); }).find("no images"), std::string::npos);
  EXPECT_NE(refusal([&] { images_of(file("nowhere")); }).find("no such folder"), std::string::npos);
}

TEST_F(ImageFolder, PairsByNameOrByNumberAndNamesWhatHasNoPartner) {
  const auto by_name = paired(named({"a.png", "b.png"}), named({"a.png", "b.png"}));
  ASSERT_EQ(by_name.size(), 2u);
  EXPECT_EQ(by_name[1].second.name, "b.png");
  const auto by_number = paired(named({"left01.jpg", "left12.jpg"}), named({"r_1.png", "r_12.png"}));
  ASSERT_EQ(by_number.size(), 2u);
  EXPECT_EQ(by_number[0].second.name, "r_1.png");
  const std::string why = refusal([] { paired(named({"left01.jpg", "left02.jpg"}), named({"right01.jpg", "right03.jpg"})); });
  EXPECT_NE(why.find("left02.jpg: has no partner"), std::string::npos) << why;
  EXPECT_NE(why.find("right03.jpg: has no partner"), std::string::npos) << why;
  EXPECT_NE(refusal([] { paired(named({"a1.png", "b1.png"}), named({"c1.png", "d2.png"})); }).find("same number"), std::string::npos);
}

}  // namespace
}  // namespace periplus::vision
