// periplus-calibrate as a person runs it: folders of images in, files and a report out.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core/persistence.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/file.h"
#include "services/vision_server/testing/chessboard_pairs.h"

namespace periplus::vision {
namespace {

namespace fs = std::filesystem;

struct Answer {
  int status = -1;
  std::string out, err;
  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

// Works on copies of the real pairs, in folders left/ and right/.
class CalibrateProgram : public ::testing::Test {
 protected:
  CalibrateProgram() : folder_(fs::temp_directory_path() / ("periplus_calibrate_program_test_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_ / "left");
    fs::create_directories(folder_ / "right");
    for (const auto& [l, r] : testing::chessboard_pairs()) {
      fs::copy_file(l.path, folder_ / "left" / l.name);
      fs::copy_file(r.path, folder_ / "right" / r.name);
    }
  }
  ~CalibrateProgram() override { fs::remove_all(folder_); }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  Answer run(const std::string& arguments) const {
    const std::string command = std::string(PERIPLUS_BIN_DIR) + "/periplus-calibrate " + arguments + " 2>" + file("err");
    Answer r;
    FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return r;
    char buffer[4096];
    for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) r.out.append(buffer, n);
    const int status = ::pclose(pipe);
    r.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    r.err = read_file(file("err"));
    return r;
  }
  Answer pair(const std::string& more = "") const { return run(file("left") + " " + file("right") + " --board 9x6 -o " + file("out") + " " + more); }
  // Refused with status 2, naming what `says`; nothing is written.
  void refused(const Answer& r, const std::vector<std::string>& says) const {
    EXPECT_EQ(r.status, 2) << r.err;
    for (const std::string& word : says) EXPECT_NE(r.err.find(word), std::string::npos) << word << " not in: " << r.err;
    EXPECT_FALSE(fs::exists(file("out")));
  }
  fs::path folder_;
};

TEST_F(CalibrateProgram, CalibratesThePairAndWritesWhatOpenCVReads) {
  const Answer r = pair("--json --square 0.025");
  ASSERT_EQ(r.status, 0) << r.err;
  const auto j = r.json();
  EXPECT_EQ(j.at("schema"), "periplus-calibrate-1");
  EXPECT_LE(j.at("rms_px").get<double>(), 0.46);
  EXPECT_NEAR(j.at("baseline").get<double>() / 0.025, 3.338, 0.03338);
  EXPECT_EQ(j.at("pairs").size(), 13u);
  EXPECT_EQ(nlohmann::json::parse(read_file(file("out/report.json"))), j);
  double greatest = 0;
  for (const auto& p : j.at("pairs"))
    for (const char* eye : {"left", "right"}) greatest = std::max(greatest, p.at(eye).at("error_px").get<double>());
  for (const auto& p : j.at("pairs"))
    if (p.at("left").at("image") == j.at("worst")) {
      EXPECT_EQ(std::max(p.at("left").at("error_px").get<double>(), p.at("right").at("error_px").get<double>()), greatest);
    }

  const cv::FileStorage stereo(file("out/stereo.yaml"), cv::FileStorage::READ), left(file("out/left.yaml"), cv::FileStorage::READ);
  cv::Mat T, P, K;
  stereo["T"] >> T;
  stereo["P2"] >> P;
  left["camera_matrix"] >> K;
  EXPECT_NEAR(cv::norm(T), j.at("baseline").get<double>(), 1e-9);
  EXPECT_NEAR(-P.at<double>(0, 3) / P.at<double>(0, 0), cv::norm(T), 1e-6);
  EXPECT_EQ(K.at<double>(0, 0), j.at("left").at("fx").get<double>());
  const cv::Mat picture = cv::imread(file("out/worst.png"));
  EXPECT_GE(picture.cols, 1800);
  cv::Mat green, red;
  cv::inRange(picture, cv::Scalar(0, 150, 0), cv::Scalar(60, 230, 60), green);
  cv::inRange(picture, cv::Scalar(0, 0, 200), cv::Scalar(80, 80, 255), red);
  EXPECT_GT(cv::countNonZero(green), 1000);
  EXPECT_GT(cv::countNonZero(red), 500);
  EXPECT_NE(read_file(file("out/view-camera.yaml")).find("baseline_m: 0.083"), std::string::npos);
}

TEST_F(CalibrateProgram, CalibratesOneCameraAndSaysItForAPerson) {
  const Answer r = run("'" + file("left") + "/left*.jpg' --board 9x6 -o " + file("out"));
  ASSERT_EQ(r.status, 0) << r.err;
  for (const char* word : {"left01.jpg", "left14.jpg", "worst", "fx 5", "lengths are in squares", "camera.yaml", "worst.png"}) EXPECT_NE(r.out.find(word), std::string::npos) << word << r.out;
  EXPECT_TRUE(fs::exists(file("out/camera.yaml")));
  EXPECT_FALSE(fs::exists(file("out/view-camera.yaml")));  // no metres
  EXPECT_EQ(r.err, "");
  std::ofstream(file("out/view-camera.yaml")) << "of another day";
  const Answer again = run("'" + file("left") + "/left*.jpg' --board 9x6 -o " + file("out"));
  EXPECT_EQ(again.status, 0);
  EXPECT_NE(again.err.find("view-camera.yaml is of an earlier calibration"), std::string::npos) << again.err;
  EXPECT_EQ(read_file(file("out/view-camera.yaml")), "of another day");
}

TEST_F(CalibrateProgram, RefusesWhatWouldSpoilItNamingTheImageAndWhy) {
  refused(run(file("right") + " " + file("left") + " --board 9x6 -o " + file("out")), {"exchange the two folders"});
  refused(run(file("left") + " " + file("left") + " --board 9x6 -o " + file("out")), {"same folder"});
  refused(pair("--least-views 14"), {"too few pairs: 13"});
  refused(run(file("left") + " " + file("right") + " --board 8x6 -o " + file("out")), {"left01.jpg", "own number"});

  const cv::Mat sharp = cv::imread(file("left/left05.jpg"), cv::IMREAD_GRAYSCALE);
  cv::Mat blurred, small;
  cv::GaussianBlur(sharp, blurred, {}, 3);
  cv::imwrite(file("left/left05.jpg"), blurred);
  cv::Mat cut = cv::imread(file("right/right12.jpg"), cv::IMREAD_GRAYSCALE);
  cut.colRange(0, 150) = 90;
  cv::imwrite(file("right/right12.jpg"), cut);
  cv::resize(sharp, small, {320, 240});
  cv::imwrite(file("left/left07.jpg"), small);
  std::ofstream(file("left/left08.jpg")) << "a text";
  const Answer r = pair("--json");
  refused(r, {"left05.jpg: blurred", "right12.jpg: ", "cover", "left07.jpg: has 320 x 240", "left08.jpg: no image"});
  EXPECT_EQ(r.err.find("left01.jpg"), std::string::npos) << r.err;
  const auto j = r.json();
  EXPECT_EQ(j.at("result"), "refused");
  EXPECT_EQ(j.at("images").size(), 4u);
  EXPECT_EQ(j.at("images")[0].at("image"), "left05.jpg");
}

TEST_F(CalibrateProgram, RefusesPairsThatDoNotMatchUp) {
  fs::rename(file("left/left07.jpg"), file("swap"));
  fs::rename(file("right/right07.jpg"), file("left/left07.jpg"));
  fs::rename(file("swap"), file("right/right07.jpg"));
  refused(pair(), {"left07.jpg with right07.jpg", "exchange its two files"});
  fs::remove(file("right/right07.jpg"));
  refused(pair(), {"left07.jpg: has no partner"});
  fs::remove(file("left/left07.jpg"));
  fs::copy_file(file("right/right03.jpg"), file("right/right02.jpg"), fs::copy_options::overwrite_existing);
  refused(pair(), {"left02.jpg with right02.jpg", "same moment"});
}

TEST_F(CalibrateProgram, RefusesACallThatMakesNoSense) {
  for (const char* bad : {"--square nan", "--square 0", "--square -1", "--square inf", "--radial 7", "--least-views 1", "--sharp nan", "--sharp 0", "--nonsense"}) refused(pair(bad), {});
  for (const char* board : {"9", "9x", "9x6x2", "0x0", "-9x6", "99999999999x6", "2x2"}) refused(run(file("left") + " --board " + board + " -o " + file("out")), {});
  fs::create_directories(file("empty"));
  refused(run(file("empty") + " --board 9x6"), {"no images"});
  std::ofstream(file("taken")) << "a file";
  EXPECT_EQ(run(file("left") + " --board 9x6 -o " + file("taken")).status, 2);
  EXPECT_EQ(run("--help").status, 0);
}

}  // namespace
}  // namespace periplus::vision
