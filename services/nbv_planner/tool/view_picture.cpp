#include "services/nbv_planner/tool/view_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace periplus::nbv {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr int kFiner = 2;                      // pixels of the voxels to one of the picture, each way
constexpr std::size_t kMostCandidates = 160;   // more hide each other
constexpr double kElevation = 27 * kPi / 180;
const Colour kChosen{0.84, 0.10, 0.16}, kInk{0.13, 0.15, 0.18}, kSoft{0.45, 0.48, 0.52}, kFaint{0.85, 0.86, 0.88};

Vector3d grid_corner(const voxel::GridGeometry& g, int c) {
  return g.X_WG * (Vector3d(c & 1, c >> 1 & 1, c >> 2 & 1).cwiseProduct(g.size.cast<double>()) * g.voxel_size);
}

Vector3d grid_middle(const voxel::GridGeometry& g) { return g.X_WG * (g.size.cast<double>() * g.voxel_size / 2); }

// The eye, then the four corners of the image at `depth` along the axis.
std::array<Vector3d, 5> pyramid(const Pose& X_WC, const Pinhole& camera, double depth) {
  std::array<Vector3d, 5> p;
  p[0] = X_WC.translation();
  const double u[] = {-0.5, camera.width - 0.5, camera.width - 0.5, -0.5}, v[] = {-0.5, -0.5, camera.height - 0.5, camera.height - 0.5};
  for (int k = 0; k < 4; ++k) p[k + 1] = X_WC * camera.back_project(u[k], v[k], depth);
  return p;
}

// What of the candidates is shown: the best first, none upon another.
std::vector<LookedAt> thinned(std::vector<LookedAt> all) {
  std::stable_sort(all.begin(), all.end(), [](const LookedAt& a, const LookedAt& b) { return a.f_e < b.f_e; });
  std::vector<LookedAt> shown;
  for (const LookedAt& c : all) {
    if (!c.feasible) continue;
    const bool close = std::any_of(shown.begin(), shown.end(), [&](const LookedAt& o) {
      return (o.X_WC.translation() - c.X_WC.translation()).norm() < 0.06 && angle_between(o.X_WC, c.X_WC) < 0.25;
    });
    if (!close) shown.push_back(c);
    if (shown.size() >= kMostCandidates) break;
  }
  return shown;
}

// Lines in space: what stands behind voxels or solids is drawn faintly.
class SpaceLines {
 public:
  SpaceLines(Canvas& canvas, const Projection& projection, const ImageF& nearness, double x, double y)
      : canvas_(canvas), projection_(projection), nearness_(nearness), origin_(x, y) {}

  void line(const Vector3d& a, const Vector3d& b, const Colour& colour, double width, bool dashed = false) {
    const Vector3d pa = projection_(a), pb = projection_(b);
    const int steps = std::clamp(static_cast<int>((pb - pa).head<2>().norm() / 3), 1, 400);
    std::vector<Vector2d> run{origin_ + pa.head<2>()};
    bool seen = visible(pa + (pb - pa) * (0.5 / steps));
    for (int k = 1; k <= steps; ++k) {
      const Vector3d p = pa + (pb - pa) * (double(k) / steps);
      run.push_back(origin_ + p.head<2>());
      const bool next = k < steps && visible(pa + (pb - pa) * ((k + 0.5) / steps));
      if (k < steps && next == seen) continue;
      canvas_.line(run, seen ? colour : colour.with_alpha(0.22 * colour.a), width, dashed);
      run = {run.back()};
      seen = next;
    }
  }
  void fill(const std::vector<Vector3d>& corners, const Colour& colour) {
    std::vector<Vector2d> points;
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& c : corners) {
      points.push_back(origin_ + projection_.point(c));
      middle += c / static_cast<double>(corners.size());
    }
    canvas_.fill(points, visible(projection_(middle)) ? colour : colour.with_alpha(0.2 * colour.a));
  }
  void frustum(const Pose& X_WC, const Pinhole& camera, double size, const Colour& colour, double width) {
    const auto p = pyramid(X_WC, camera, size);
    fill({p[1], p[2], p[3], p[4]}, colour.with_alpha(0.35 * colour.a));
    for (int k = 1; k <= 4; ++k) {
      line(p[0], p[k], colour, width);
      line(p[k], p[k % 4 + 1], colour, width);
    }
  }

 private:
  bool visible(const Vector3d& p) const {
    const int u = static_cast<int>(std::lround(p.x() * kFiner)), v = static_cast<int>(std::lround(p.y() * kFiner));
    if (u < 0 || v < 0 || u >= nearness_.width || v >= nearness_.height) return true;
    return p.z() >= nearness_.at(u, v) - 0.01;
  }

  Canvas& canvas_;
  const Projection& projection_;
  const ImageF& nearness_;
  Vector2d origin_;
};

// Parallel lines such that the points fill the rectangle.
Projection fitted(double azimuth, double elevation, const std::vector<Vector3d>& points, int width, int height) {
  const Projection unit = elevation > 1.5 ? Projection::above(Vector3d::Zero(), 1, 0, 0) : Projection::parallel(azimuth, elevation, Vector3d::Zero(), 1, 0, 0);
  Vector2d low = Vector2d::Constant(1e9), high = Vector2d::Constant(-1e9);
  for (const Vector3d& p : points) {
    low = low.cwiseMin(unit.point(p));
    high = high.cwiseMax(unit.point(p));
  }
  const Vector2d size = (high - low).cwiseMax(0.2);
  const double scale = 0.92 * std::min(width / size.x(), height / size.y());
  // The point of space that `unit` puts into the middle.
  const Vector2d at = (low + high) / 2;
  const Vector3d away(-std::cos(elevation) * std::cos(azimuth), -std::cos(elevation) * std::sin(azimuth), -std::sin(elevation));
  const Vector3d right(-std::sin(azimuth), std::cos(azimuth), 0);
  const Vector3d middle = elevation > 1.5 ? Vector3d(at.x(), -at.y(), 0) : Vector3d(at.x() * right + at.y() * away.cross(right));
  return elevation > 1.5 ? Projection::above(middle, scale, width, height) : Projection::parallel(azimuth, elevation, middle, scale, width, height);
}

void scale_bar(Canvas& canvas, double px_per_m, double x, double y) {
  const double length = px_per_m > 260 ? 0.2 : px_per_m > 110 ? 0.5 : px_per_m > 45 ? 1.0 : 2.0;
  canvas.line({{x, y}, {x + length * px_per_m, y}}, kInk, 3);
  char text[20];
  std::snprintf(text, sizeof text, "%g m", length);
  canvas.text(x + length * px_per_m / 2, y - 7, text, 13, kInk, Align::center);
}

// The room's floor and the object's box, as far as they help to see where things stand.
void draw_floor(SpaceLines& lines, const std::vector<Vector3d>& around) {
  Vector3d low = around.front(), high = around.front();
  for (const Vector3d& p : around) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double step = (high - low).head<2>().maxCoeff() > 8 ? 2 : (high - low).head<2>().maxCoeff() > 3 ? 0.5 : 0.25;
  const Vector2d a = (low.head<2>() / step).array().floor() * step, b = (high.head<2>() / step).array().ceil() * step;
  for (double x = a.x(); x <= b.x() + 1e-9; x += step) lines.line({x, a.y(), 0}, {x, b.y(), 0}, kFaint, 1);
  for (double y = a.y(); y <= b.y() + 1e-9; y += step) lines.line({a.x(), y, 0}, {b.x(), y, 0}, kFaint, 1);
}

void draw_box(SpaceLines& lines, const voxel::GridGeometry& g) {
  for (int c = 0; c < 8; ++c)
    for (int axis = 0; axis < 3; ++axis)
      if (!(c >> axis & 1)) lines.line(grid_corner(g, c), grid_corner(g, c | 1 << axis), kSoft.with_alpha(0.6), 1, true);
}

// What a picture must show: the object's box, the poses, and the solids among them.
std::vector<Vector3d> extent(const Situation& s, const std::vector<Pose>& poses, bool floor) {
  std::vector<Vector3d> points;
  for (int c = 0; c < 8; ++c) points.push_back(grid_corner(s.grid->geometry(), c));
  for (const Pose& X : poses) {
    points.push_back(X.translation());
    points.push_back(X * Vector3d(0, 0, 0.15));
    if (floor) points.emplace_back(X.translation().x(), X.translation().y(), 0);
  }
  Vector3d low = points.front(), high = points.front();
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  for (const scene::Solid& solid : s.scene.solids) {
    const Vector3d middle = solid.X_WS.translation();
    if ((middle.head<2>().array() < low.head<2>().array() - 0.2).any() || (middle.head<2>().array() > high.head<2>().array() + 0.2).any()) continue;
    for (int c = 0; c < 8; ++c) {
      const Vector3d corner = solid.X_WS * (Vector3d(c & 1, c >> 1 & 1, c >> 2 & 1).array() - 0.5).matrix().cwiseProduct(solid.size);
      // Of a wall only what is near.
      points.push_back(corner.cwiseMax(low - Vector3d(0.6, 0.6, 5)).cwiseMin(high + Vector3d(0.6, 0.6, 5)));
    }
  }
  return points;
}

void panel_title(Canvas& canvas, double x, double y, const std::string& text) { canvas.text(x, y, text, 16, kInk, Align::left, true); }

void legend_patch(Canvas& canvas, double x, double y, const Colour& colour, const std::string& text) {
  canvas.fill({{x, y - 12}, {x + 16, y - 12}, {x + 16, y + 3}, {x, y + 3}}, colour);
  canvas.text(x + 24, y, text, 14, kInk);
}

}  // namespace

void draw_side_view(Canvas& canvas, const Situation& s, const std::vector<SideViewPose>& poses, double azimuth, double x, double y,
                    int width, int height) {
  std::vector<Pose> all;
  for (const SideViewPose& p : poses) all.push_back(p.X_WC);
  const std::vector<Vector3d> around = extent(s, all, true);
  const Projection projection = fitted(azimuth, kElevation, around, width, height);
  const VoxelView voxels = draw_voxels(*s.grid, s.scene, projection.finer(kFiner));
  canvas.clip(x, y, width, height);
  SpaceLines lines(canvas, projection, voxels.nearness, x, y);
  draw_floor(lines, around);
  canvas.image(voxels.rgba, x, y, width, height);
  draw_box(lines, s.grid->geometry());
  // The farthest first.
  std::vector<SideViewPose> order = poses;
  std::stable_sort(order.begin(), order.end(), [&](const SideViewPose& a, const SideViewPose& b) {
    return a.size != b.size ? a.size < b.size : projection(a.X_WC.translation()).z() < projection(b.X_WC.translation()).z();
  });
  for (const SideViewPose& p : order) {
    if (p.sight > 0) {  // as far as the object
      const auto corner = pyramid(p.X_WC, s.rig.camera, p.sight);
      for (int k = 1; k <= 4; ++k) {
        lines.line(corner[0], corner[k], p.colour.with_alpha(0.55), 1, true);
        lines.line(corner[k], corner[k % 4 + 1], p.colour.with_alpha(0.55), 1, true);
      }
    }
    lines.frustum(p.X_WC, s.rig.camera, p.size, p.colour, p.size > 0.12 ? 2.4 : 1.1);
  }
  scale_bar(canvas, projection.px_per_m(), x + 14, y + height - 14);
  canvas.unclip();
}

void draw_view(const std::string& file, const Evaluator& evaluator, const ViewPicture& picture) {
  const Situation& s = evaluator.situation();
  const voxel::GridGeometry& g = s.grid->geometry();
  constexpr double kWidth = 1600, kHeight = 1080, kLeft = 940, kTop = 92;
  Canvas canvas(file, kWidth, kHeight);
  canvas.text(36, 44, picture.title, 26, kInk, Align::left, true);
  canvas.text(36, 70, picture.subtitle, 15, kSoft);

  const std::vector<LookedAt> shown = thinned(picture.candidates);
  const double best = picture.f_e;
  double worst = best + 1;
  if (!shown.empty()) worst = std::max(worst, shown[shown.size() * 9 / 10].f_e);
  if (best < -1) worst = std::min(worst, 0.0);  // from here on a view costs more than it shows
  const auto colour = [&](double f) { return viridis((worst - f) / (worst - best)); };

  // From the side; the viewer stands where the chosen view is seen looking across the picture.
  const Vector3d middle = grid_middle(g);
  const Vector3d from = picture.X_WC.translation() - middle;
  const double azimuth = std::atan2(from.y(), from.x()) + 62 * kPi / 180;
  std::vector<SideViewPose> poses;
  for (auto it = shown.rbegin(); it != shown.rend(); ++it) poses.push_back({it->X_WC, colour(it->f_e), 0.09, 0});
  poses.push_back({picture.X_WC, kChosen, 0.22, std::max(0.3, (picture.X_WC.inverse() * middle).z())});
  panel_title(canvas, 36, kTop + 20, "model, obstacles and the poses looked at");
  draw_side_view(canvas, s, poses, azimuth, 30, kTop + 30, 890, 700);

  // From above.
  const double top_x = kLeft, top_y = kTop + 30;
  constexpr int kTopWidth = 620, kTopHeight = 470;
  std::vector<Pose> all{picture.X_WC};
  for (const LookedAt& c : shown) all.push_back(c.X_WC);
  const Projection above = fitted(0, kPi / 2, extent(s, all, false), kTopWidth, kTopHeight);
  const VoxelView voxels = draw_voxels(*s.grid, s.scene, above.finer(kFiner));
  panel_title(canvas, top_x, kTop + 20, "from above");
  canvas.clip(top_x, top_y, kTopWidth, kTopHeight);
  canvas.image(voxels.rgba, top_x, top_y, kTopWidth, kTopHeight);
  const auto at = [&](const Vector3d& p) { return Vector2d(Vector2d(top_x, top_y) + above.point(p)); };
  const double far = evaluator.settings().pair.depth_max, near = evaluator.settings().pair.depth_min;
  const double tan_h = s.rig.camera.width / 2.0 / s.rig.camera.fx;
  const auto sector = [&](const Pose& X, double from_depth, double to_depth) {
    return std::vector<Vector2d>{at(X * Vector3d(-tan_h * from_depth, 0, from_depth)), at(X * Vector3d(-tan_h * to_depth, 0, to_depth)),
                                 at(X * Vector3d(tan_h * to_depth, 0, to_depth)), at(X * Vector3d(tan_h * from_depth, 0, from_depth))};
  };
  std::vector<Pose> eyes{picture.X_WC};
  if (s.rig.baseline > 0) eyes.push_back(picture.X_WC * Pose(Eigen::Translation3d(s.rig.baseline, 0, 0)));
  for (const Pose& eye : eyes) canvas.fill(sector(eye, near, far), kChosen.with_alpha(0.10));
  for (auto it = shown.rbegin(); it != shown.rend(); ++it) {
    std::vector<Vector2d> wedge = sector(it->X_WC, 0, 0.09);
    canvas.fill(wedge, colour(it->f_e).with_alpha(0.55));
    canvas.disc(at(it->X_WC.translation()), 2.2, colour(it->f_e));
  }
  for (const Pose& F : s.forbidden) {
    const Vector2d p = at(F.translation());
    canvas.line({p - Vector2d(6, 6), p + Vector2d(6, 6)}, kInk, 2);
    canvas.line({p - Vector2d(6, -6), p + Vector2d(6, -6)}, kInk, 2);
  }
  for (const Pose& eye : eyes) {
    const Vector2d e = at(eye.translation());
    canvas.line({e, at(eye * Vector3d(-tan_h * far, 0, far))}, kChosen.with_alpha(0.7), 1.2, true);
    canvas.line({e, at(eye * Vector3d(tan_h * far, 0, far))}, kChosen.with_alpha(0.7), 1.2, true);
    canvas.disc(e, 5.5, kChosen);
  }
  scale_bar(canvas, above.px_per_m(), top_x + 14, top_y + kTopHeight - 14);
  const Vector2d axes(top_x + kTopWidth - 62, top_y + kTopHeight - 20);
  canvas.line({axes, axes + Vector2d(36, 0)}, kInk, 1.6);
  canvas.line({axes, axes + Vector2d(0, -36)}, kInk, 1.6);
  canvas.text(axes.x() + 42, axes.y() + 5, "x", 14, kInk);
  canvas.text(axes.x() - 4, axes.y() - 42, "y", 14, kInk);
  canvas.unclip();
  canvas.rectangle(top_x, top_y, kTopWidth, kTopHeight, kFaint, 1);

  // What it sees.
  const double eye_y = top_y + kTopHeight + 44;
  const double eye_height = 370, eye_width = std::min(620.0, eye_height * s.rig.camera.width / s.rig.camera.height);
  panel_title(canvas, top_x, eye_y - 12, s.rig.baseline > 0 ? "what the left eye would see" : "what the camera would see");
  const VoxelView seen = draw_voxels(*s.grid, s.scene, Projection::camera(picture.X_WC, s.rig.camera).finer(kFiner));
  canvas.image(seen.rgba, top_x, eye_y, eye_width, eye_height);
  canvas.rectangle(top_x, eye_y, eye_width, eye_height, kSoft, 1);

  // Legend and facts.
  const double y = kTop + 760;
  legend_patch(canvas, 36, y, {0.38, 0.76, 0.36}, "unknown");
  legend_patch(canvas, 136, y, {0.66, 0.68, 0.72}, "known");
  legend_patch(canvas, 222, y, {0.55, 0.40, 0.27}, "environment in the grid");
  legend_patch(canvas, 428, y, {0.85, 0.79, 0.68}, "obstacle");
  legend_patch(canvas, 532, y, kChosen, "chosen view");
  if (!s.forbidden.empty()) canvas.text(660, y, "\u00d7 forbidden", 14, kInk);
  constexpr int kSteps = 64;
  ImageU8 bar(kSteps, 1, 3);
  for (int i = 0; i < kSteps; ++i) {
    const Colour k = viridis(i / (kSteps - 1.0));
    bar.at(i, 0, 0) = static_cast<std::uint8_t>(255 * k.r);
    bar.at(i, 0, 1) = static_cast<std::uint8_t>(255 * k.g);
    bar.at(i, 0, 2) = static_cast<std::uint8_t>(255 * k.b);
  }
  canvas.image(bar, 36, y + 22, 300, 14);
  char text[80];
  std::snprintf(text, sizeof text, "f_e \u2265 %.0f", worst);
  canvas.text(36, y + 54, text, 13, kInk);
  std::snprintf(text, sizeof text, "best: %.0f", best);
  canvas.text(336, y + 54, text, 13, kInk, Align::right);
  std::snprintf(text, sizeof text, "%zu of %zu poses looked at", shown.size(), picture.candidates.size());
  canvas.text(360, y + 34, text, 13, kSoft);
  for (std::size_t i = 0; i < picture.facts.size(); ++i) {
    const double column = 36 + 300.0 * static_cast<double>(i / 5), row = y + 90 + 24.0 * static_cast<double>(i % 5);
    canvas.text(column, row, picture.facts[i].first, 14, kSoft);
    canvas.text(column + 112, row, picture.facts[i].second, 14, kInk);
  }
  canvas.save();
}

}  // namespace periplus::nbv
