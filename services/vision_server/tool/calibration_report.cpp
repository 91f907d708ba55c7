#include "services/vision_server/tool/calibration_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace periplus::vision {
namespace {

template <class... Values>
std::string line(const char* pattern, Values... values) {
  char text[400];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

std::vector<const CameraFit*> eyes(const Calibrated& c) {
  if (c.pair) return {&c.pair->left, &c.pair->right};
  return {&*c.camera};
}

double error_of(const Calibrated& c, std::size_t n) {
  double out = 0;
  for (const CameraFit* eye : eyes(c)) out = std::max(out, eye->views[n].error_px);
  return out;
}

std::string camera_text(const CameraFit& f, const char* name) {
  const auto& d = f.distortion;
  return line("%-8s fx %.2f fy %.2f cx %.2f cy %.2f px (focal length to %.2f px); k1 %.4f k2 %.4f p1 %.5f p2 %.5f k3 %.4f\n", name, f.K(0, 0), f.K(1, 1), f.K(0, 2),
              f.K(1, 2), f.focal_sigma_px, d[0], d[1], d[2], d[3], d[4]) +
         line("         RMS %.3f px; corners seen in %.0f %% of the image%s\n", f.rms_px, 100 * f.coverage,
              f.coverage < 0.6 ? ": show the board in the empty parts too, distortion there is a guess" : "");
}

nlohmann::ordered_json camera_json(const CameraFit& f) {
  return {{"fx", f.K(0, 0)}, {"fy", f.K(1, 1)}, {"cx", f.K(0, 2)}, {"cy", f.K(1, 2)}, {"focal_sigma_px", f.focal_sigma_px},
          {"distortion", f.distortion}, {"rms_px", f.rms_px}, {"coverage", f.coverage}};
}

nlohmann::ordered_json view_json(const FittedView& v) { return {{"image", v.name}, {"error_px", v.error_px}, {"edge_px", v.edge_px}}; }

// One eye's picture, `scale` times as large as the image.
cv::Mat drawn(const FittedView& view, const ImageU8& image, double scale) {
  cv::Mat grey(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data.data())), large, out;
  cv::resize(grey, large, {}, scale, scale, scale > 1 ? cv::INTER_LINEAR : cv::INTER_AREA);
  cv::cvtColor(large, out, cv::COLOR_GRAY2BGR);
  out.convertTo(out, -1, 0.6, 40);  // paler, that the marks stand out
  constexpr int kShift = 4;
  const auto place = [&](const Eigen::Vector2d& p) {
    return cv::Point(static_cast<int>(std::lround(((p.x() + 0.5) * scale - 0.5) * (1 << kShift))), static_cast<int>(std::lround(((p.y() + 0.5) * scale - 0.5) * (1 << kShift))));
  };
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    const cv::Point found = place(view.corners[i]), back = place(view.reprojected[i]);
    cv::line(out, found, place(view.corners[i] + 20 * (view.reprojected[i] - view.corners[i])), {0, 220, 255}, 2, cv::LINE_AA, kShift);
    cv::circle(out, found, 6 << kShift, {0, 200, 0}, 1, cv::LINE_AA, kShift);
    const int arm = 4 << kShift;
    cv::line(out, back - cv::Point(arm, arm), back + cv::Point(arm, arm), {0, 0, 255}, 1, cv::LINE_AA, kShift);
    cv::line(out, back - cv::Point(arm, -arm), back + cv::Point(arm, -arm), {0, 0, 255}, 1, cv::LINE_AA, kShift);
  }
  return out;
}

void write(cv::Mat& picture, const std::string& text, cv::Point at) { cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.55, {30, 30, 30}, 1, cv::LINE_AA); }

}  // namespace

std::size_t worst_view(const Calibrated& c) {
  std::size_t worst = 0;
  for (std::size_t n = 1; n < eyes(c)[0]->views.size(); ++n)
    if (error_of(c, n) > error_of(c, worst)) worst = n;
  return worst;
}

std::string report_text(const Calibrated& c) {
  const char* unit = c.metric ? "m" : "squares";
  const CameraFit& first = *eyes(c)[0];
  std::string out = line("board    %d x %d corners, squares of %g %s\n", c.board.columns, c.board.rows, c.board.square, c.metric ? "m" : "(no --square: lengths are in squares)");
  out += line("images   %zu%s of %d x %d px\n\n", first.views.size(), c.pair ? " pairs" : "", first.width, first.height);
  out += c.pair ? line("%-32s %10s %10s %12s\n", "pair", "left px", "right px", "sharpness px") : line("%-32s %10s %12s\n", "image", "error px", "sharpness px");
  const std::size_t worst = worst_view(c);
  for (std::size_t n = 0; n < first.views.size(); ++n) {
    const FittedView& l = first.views[n];
    if (c.pair) {
      const FittedView& r = c.pair->right.views[n];
      out += line("%-32s %10.3f %10.3f %12.1f", (l.name + " " + r.name).c_str(), l.error_px, r.error_px, std::max(l.edge_px, r.edge_px));
    } else {
      out += line("%-32s %10.3f %12.1f", l.name.c_str(), l.error_px, l.edge_px);
    }
    out += n == worst ? "   worst\n" : "\n";
  }
  out += "\n";
  if (c.pair) {
    out += camera_text(c.pair->left, "left") + camera_text(c.pair->right, "right");
    const Eigen::Vector3d& T = c.pair->T;
    out += line("pair     RMS %.3f px; baseline %.6g %s, T (%.6g, %.6g, %.6g); rectified rows differ by %.3f px\n", c.pair->rms_px, c.pair->baseline(), unit, T.x(), T.y(), T.z(),
                c.pair->row_px);
  } else {
    out += camera_text(*c.camera, "camera");
  }
  for (const std::string& file : c.files) out += "wrote    " + file + "\n";
  return out;
}

std::string report_json(const Calibrated& c) {
  nlohmann::ordered_json j;
  j["schema"] = "periplus-calibrate-1";
  j["result"] = "calibrated";
  j["board"] = {{"columns", c.board.columns}, {"rows", c.board.rows}, {"square", c.board.square}};
  j["unit"] = c.metric ? "m" : "squares";
  const CameraFit& first = *eyes(c)[0];
  j["image_size"] = {first.width, first.height};
  if (c.pair) {
    const PairFit& p = *c.pair;
    j["rms_px"] = p.rms_px;
    j["baseline"] = p.baseline();
    j["T"] = {p.T.x(), p.T.y(), p.T.z()};
    j["row_px"] = p.row_px;
    j["left"] = camera_json(p.left);
    j["right"] = camera_json(p.right);
    for (std::size_t n = 0; n < p.left.views.size(); ++n) j["pairs"].push_back({{"left", view_json(p.left.views[n])}, {"right", view_json(p.right.views[n])}});
  } else {
    j["rms_px"] = first.rms_px;
    j["camera"] = camera_json(first);
    for (const FittedView& v : first.views) j["images"].push_back(view_json(v));
  }
  j["worst"] = first.views[worst_view(c)].name;
  j["files"] = c.files;
  return j.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string refusal_json(const std::string& reason, const std::vector<ViewFault>& faults) {
  nlohmann::ordered_json j;
  j["schema"] = "periplus-calibrate-1";
  j["result"] = "refused";
  j["reason"] = reason;
  j["images"] = nlohmann::ordered_json::array();
  for (const ViewFault& f : faults) j["images"].push_back({{"image", f.name}, {"why", f.why}});
  return j.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string view_picture(const Calibrated& c, std::size_t n, const std::vector<ImageU8>& images) {
  const double scale = std::clamp(900.0 / images[0].width, 0.1, 8.0);
  std::vector<cv::Mat> halves;
  for (std::size_t eye = 0; eye < images.size(); ++eye) halves.push_back(drawn(eyes(c)[eye]->views[n], images[eye], scale));
  cv::Mat both, picture;
  cv::hconcat(halves, both);
  constexpr int kBand = 62;
  cv::copyMakeBorder(both, picture, kBand, 0, 0, 0, cv::BORDER_CONSTANT, {245, 245, 245});
  for (std::size_t eye = 0; eye < images.size(); ++eye) {
    const FittedView& v = eyes(c)[eye]->views[n];
    write(picture, line("%s: error %.3f px, edges %.1f px wide", v.name.substr(0, 60).c_str(), v.error_px, v.edge_px), {12 + static_cast<int>(eye) * halves[0].cols, 24});
  }
  write(picture, "green circle: corner found; red cross: reprojected; yellow: the error, 20 times as long", {12, 50});
  std::vector<std::uint8_t> png;
  cv::imencode(".png", picture, png);
  return {png.begin(), png.end()};
}

}  // namespace periplus::vision
