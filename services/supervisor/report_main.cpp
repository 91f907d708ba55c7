// `periplus report RUN`: writes RUN/report.html anew. `--pictures FOLDER` also puts the pictures of a README there: what the
// robot saw at its second look, and the model from all sides. `--figures FOLDER` writes the room with the robot in all its postures,
// what is still unknown, and the model after each look; `--azimuth DEGREES` says from which side.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "services/supervisor/figures/run_figures.h"
#include "services/supervisor/model_view.h"
#include "services/supervisor/run_report.h"

namespace {

namespace fs = std::filesystem;
using namespace periplus;

void write_pictures(const std::string& run, const std::string& folder) {
  fs::create_directories(folder);
  for (const char* name : {"left", "right", "wide", "depth", "disparity"}) {
    const fs::path source = fs::path(run) / "looks/02" / (std::string(name) + ".png");
    if (fs::exists(source)) fs::copy_file(source, fs::path(folder) / (std::string("look-") + name + ".png"), fs::copy_options::overwrite_existing);
  }
  std::vector<cv::Mat> row;
  for (const supervisor::ModelView& view : supervisor::model_views(run + "/model.ply", 480)) {
    const cv::Mat rgb(view.image.height, view.image.width, CV_8UC3, const_cast<std::uint8_t*>(view.image.data.data()));
    cv::Mat bgr;
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    cv::imwrite(folder + "/model-" + view.name + ".png", bgr);
    if (row.size() < 4) row.push_back(bgr);
  }
  require(!row.empty(), ErrorCode::bad_input, run + " has no model.ply to draw");
  cv::Mat sides;
  cv::hconcat(row, sides);
  cv::imwrite(folder + "/model-four-sides.png", sides);
}

}  // namespace

int main(int argc, char** argv) {
  std::string run, pictures, figures;
  supervisor::FigureOptions options;
  bool usable = argc > 1;
  for (int i = 1; i < argc && usable; ++i) {
    const std::string argument = argv[i];
    if (argument == "--pictures" && i + 1 < argc)
      pictures = argv[++i];
    else if (argument == "--figures" && i + 1 < argc)
      figures = argv[++i];
    else if (argument == "--azimuth" && i + 1 < argc) {
      char* end = nullptr;
      options.azimuth_deg = std::strtod(argv[++i], &end);
      usable = *argv[i] != '\0' && *end == '\0' && std::isfinite(*options.azimuth_deg);
    }
    else if (argument.front() != '-' && run.empty())
      run = argument;
    else
      usable = false;
  }
  if (!usable || run.empty()) {
    std::fprintf(stderr, "usage: periplus-report RUN_FOLDER [--pictures FOLDER] [--figures FOLDER [--azimuth DEGREES]]\nWrites RUN_FOLDER/report.html from the run's files; pictures of the looks and the model, figures of the postures, too.\n");
    return 2;
  }
  try {
    supervisor::write_html_report(run);
    std::printf("%s/report.html\n", run.c_str());
    if (!pictures.empty()) write_pictures(run, pictures);
    if (!figures.empty())
      for (const std::string& path : supervisor::write_figures(run, figures, options)) std::printf("%s\n", path.c_str());
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "periplus-report: %s\n", e.what());
    return 2;
  }
}
