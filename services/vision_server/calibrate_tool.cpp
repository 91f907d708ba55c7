// `periplus calibrate`: cameras from folders of chessboard images, without a robot and without DDS. README.md, "Calibration".
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <opencv2/core/utils/logger.hpp>

#include "common/core/error.h"
#include "common/core/version.h"
#include "services/vision_server/calibration.h"
#include "services/vision_server/calibration_file.h"
#include "services/vision_server/rectification.h"
#include "services/vision_server/tool/calibration_report.h"
#include "services/vision_server/tool/image_folder.h"

namespace {

using namespace periplus;
using namespace periplus::vision;

struct Options {
  std::string left, right, board, output = "calibration";
  double square = 0;  // [m]; 0: not given
  bool json = false;
  BoardLimits limits;
  CalibrationSettings settings;
};

Chessboard board_of(const Options& o, bool square_given) {
  Chessboard board;
  int end = 0;
  require(std::sscanf(o.board.c_str(), "%dx%d%n", &board.columns, &board.rows, &end) == 2 && end == static_cast<int>(o.board.size()), ErrorCode::bad_input,
          "--board " + o.board + ": columns x rows of inner corners are expected, for example 9x6");
  if (square_given) board.square = o.square;
  board.check();
  require(!square_given || o.square <= 10, ErrorCode::bad_input, "--square " + std::to_string(o.square) + ": a side in metres, at most 10, is expected");
  return board;
}

// The boards of one camera's images. All images that cannot be used are refused together.
struct Found {
  int width = 0, height = 0;
  std::vector<NamedView> views;
};
Found find_boards(const std::vector<ImageFile>& files, const Chessboard& board, const BoardLimits& limits, std::vector<ViewFault>& faults) {
  Found out;
  std::map<std::pair<int, int>, std::vector<std::string>> sizes;
  for (const ImageFile& file : files) {
    try {
      const ImageU8 image = load_grey(file.path);
      sizes[{image.width, image.height}].push_back(file.name);
      BoardSearch search = find_board(image, board, limits);
      if (search.view) out.views.push_back({file.name, std::move(*search.view)});
      else faults.push_back({file.name, search.why});
    } catch (const Error& e) {
      faults.push_back({file.name, e.what()});
    }
  }
  std::size_t most = 0;
  for (const auto& [size, names] : sizes)
    if (names.size() > most) {
      most = names.size();
      std::tie(out.width, out.height) = size;
    }
  for (const auto& [size, names] : sizes)
    if (size != std::pair(out.width, out.height))
      for (const std::string& name : names)
        faults.push_back({name, "has " + std::to_string(size.first) + " x " + std::to_string(size.second) + " pixels, the others " + std::to_string(out.width) + " x " +
                                    std::to_string(out.height) + "; images of one resolution are expected"});
  return out;
}

int calibrate(const Options& o, bool square_given) {
  Calibrated done;
  done.board = board_of(o, square_given);
  done.metric = square_given;
  o.settings.check();
  require(o.limits.edge_px > 0, ErrorCode::bad_input, "--sharp: a positive width in pixels is expected");
  std::vector<std::pair<ImageFile, ImageFile>> pairs;
  std::vector<ImageFile> left = images_of(o.left), right;
  if (!o.right.empty()) {
    std::error_code problem;
    require(!std::filesystem::equivalent(o.left, o.right, problem) && o.left != o.right, ErrorCode::bad_input, "left and right are the same folder; give a folder or a pattern for each camera");
    pairs = paired(left, images_of(o.right));
    left.clear();
    for (const auto& [l, r] : pairs) {
      left.push_back(l);
      right.push_back(r);
    }
  }
  std::vector<ViewFault> faults;
  const Found seen_left = find_boards(left, done.board, o.limits, faults);
  const Found seen_right = find_boards(right, done.board, o.limits, faults);
  if (!faults.empty()) throw BadViews(faults);
  const int width = seen_left.width, height = seen_left.height;
  std::vector<std::pair<std::string, std::string>> files;  // name, bytes
  StereoRig rig;
  if (o.right.empty()) {
    done.camera = calibrate_camera(seen_left.views, width, height, done.board, o.settings);
    const CameraCalibration flat = done.camera->undistorted();
    files.emplace_back("camera.yaml", camera_yaml(*done.camera, flat, "camera", done.board));
    rig.camera = {width, height, flat.P(0, 0), flat.P(1, 1), flat.P(0, 2), flat.P(1, 2)};
  } else {
    require(seen_right.width == width && seen_right.height == height, ErrorCode::bad_input,
            "the left images have " + std::to_string(width) + " x " + std::to_string(height) + " pixels, the right ones " + std::to_string(seen_right.width) + " x " +
                std::to_string(seen_right.height) + "; set both cameras to one resolution");
    std::vector<std::pair<NamedView, NamedView>> views;
    for (std::size_t n = 0; n < seen_left.views.size(); ++n) views.emplace_back(seen_left.views[n], seen_right.views[n]);
    done.pair = calibrate_pair(views, width, height, done.board, o.settings);
    files.emplace_back("left.yaml", camera_yaml(done.pair->left, done.pair->left_rectified, "left", done.board));
    files.emplace_back("right.yaml", camera_yaml(done.pair->right, done.pair->right_rectified, "right", done.board));
    files.emplace_back("stereo.yaml", pair_yaml(*done.pair, done.board));
    rig = rig_of(done.pair->left_rectified, done.pair->right_rectified);
  }
  if (done.metric) files.emplace_back("view-camera.yaml", view_camera_yaml(rig, "calibrated"));
  const std::size_t worst = worst_view(done);
  std::vector<ImageU8> images{load_grey(left[worst].path)};
  if (done.pair) images.push_back(load_grey(right[worst].path));
  files.emplace_back("worst.png", view_picture(done, worst, images));

  const std::filesystem::path folder(o.output);
  for (const auto& [name, bytes] : files) done.files.push_back((folder / name).string());
  done.files.push_back((folder / "report.json").string());
  files.emplace_back("report.json", report_json(done));
  write_files(o.output, files);
  std::error_code problem;
  if (const auto before = folder / "view-camera.yaml"; !done.metric && std::filesystem::exists(before, problem))
    std::cerr << "periplus calibrate: " << before.string() << " is of an earlier calibration: calibrate with --square to have it written again, or remove it" << std::endl;
  std::cout << (o.json ? report_json(done) : report_text(done)) << std::flush;
  return 0;
}

int refused(const Options& o, const Error& e, const std::vector<ViewFault>& faults) {
  if (o.json) std::cout << refusal_json(e.what(), faults) << std::flush;
  std::cerr << "periplus calibrate: " << (faults.empty() ? "" : "refused, nothing is written\n") << e.what() << std::endl;
  return e.code() == ErrorCode::internal ? 1 : 2;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Calibrates a camera, or a pair, from images of a chessboard: YAML in OpenCV's format, a report, a picture of the worst image.");
  app.name("periplus calibrate");
  app.set_version_flag("--version", std::string("periplus ") + version());
  Options o;
  app.add_option("left", o.left, "folder of images, or a pattern in quotes: 'data/left*.jpg'; of the only camera, or of the left one")->required();
  app.add_option("right", o.right, "the same of the right camera; pairs are told by name or by the last number in it");
  app.add_option("--board", o.board, "inner corners, columns x rows: 9x6 for a board of 10 x 7 squares")->required();
  CLI::Option* square = app.add_option("--square", o.square, "a square's side [m]; without it lengths are in squares");
  app.add_option("-o,--output", o.output, "folder for the results, made if it is not there (calibration)");
  app.add_option("--least-views", o.settings.least_views, "images, or pairs, that must differ, 3 or more (8)");
  app.add_option("--radial", o.settings.radial, "radial coefficients: 2, or 3 for wide lenses and 20 images or more (2)");
  app.add_option("--sharp", o.limits.edge_px, "widest edge that counts as sharp [px], in proportion more above 1280 px of width (4.5)");
  app.add_flag("--json", o.json, "print JSON");
  app.footer("Exit status: 0 calibrated, 2 refused: the images or the call, with each image and why, 1 otherwise.");
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  try {
    app.parse(argc, argv);
    return calibrate(o, square->count() > 0);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const BadViews& e) {
    return refused(o, e, e.faults());
  } catch (const Error& e) {
    return refused(o, e, {});
  } catch (const std::exception& e) {
    std::cerr << "periplus calibrate: " << e.what() << std::endl;
    return 1;
  }
}
