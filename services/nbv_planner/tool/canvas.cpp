#include "services/nbv_planner/tool/canvas.h"

#include <cairo-svg.h>
#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>

#include "common/core/error.h"

namespace periplus::nbv {
namespace {

cairo_status_t append(void* to, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

void set_font(cairo_t* c, double size, bool bold) {
  cairo_select_font_face(c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(c, size);
}

}  // namespace

struct Canvas::Impl {
  std::string file, bytes;
  bool svg = false;
  cairo_surface_t* surface = nullptr;
  cairo_t* c = nullptr;

  void colour(const Colour& k) { cairo_set_source_rgba(c, k.r, k.g, k.b, k.a); }
  void path(const std::vector<Eigen::Vector2d>& points) {
    cairo_new_path(c);
    for (const auto& p : points) cairo_line_to(c, p.x(), p.y());
  }
  ~Impl() {
    if (c != nullptr) cairo_destroy(c);
    if (surface != nullptr) cairo_surface_destroy(surface);
  }
};

Canvas::Canvas(const std::string& file, double width, double height) : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  impl_->svg = file.ends_with(".svg");
  require(impl_->svg || file.ends_with(".png"), ErrorCode::bad_input, file + ": a picture's name must end in .png or .svg");
  // Before the work is done, rather than after it.
  require_writable(file);
  impl_->surface = impl_->svg ? cairo_svg_surface_create_for_stream(append, &impl_->bytes, width, height)
                              : cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width), static_cast<int>(height));
  impl_->c = cairo_create(impl_->surface);
  impl_->colour({1, 1, 1});
  cairo_paint(impl_->c);
  cairo_set_line_join(impl_->c, CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_cap(impl_->c, CAIRO_LINE_CAP_ROUND);
}

Canvas::~Canvas() = default;

void Canvas::line(const std::vector<Eigen::Vector2d>& points, const Colour& colour, double width, bool dashed) {
  impl_->path(points);
  impl_->colour(colour);
  cairo_set_line_width(impl_->c, width);
  const double dashes[] = {4 * width, 3 * width};
  cairo_set_dash(impl_->c, dashes, dashed ? 2 : 0, 0);
  cairo_stroke(impl_->c);
}

void Canvas::fill(const std::vector<Eigen::Vector2d>& polygon, const Colour& colour) {
  impl_->path(polygon);
  cairo_close_path(impl_->c);
  impl_->colour(colour);
  cairo_fill(impl_->c);
}

void Canvas::rectangle(double x, double y, double width, double height, const Colour& colour, double line_width) {
  line({{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}, {x, y}}, colour, line_width);
}

void Canvas::disc(const Eigen::Vector2d& center, double radius, const Colour& colour) {
  cairo_new_path(impl_->c);
  cairo_arc(impl_->c, center.x(), center.y(), radius, 0, 2 * std::numbers::pi);
  impl_->colour(colour);
  cairo_fill(impl_->c);
}

double Canvas::text_width(const std::string& text, double size, bool bold) const {
  set_font(impl_->c, size, bold);
  cairo_text_extents_t e;
  cairo_text_extents(impl_->c, text.c_str(), &e);
  return e.x_advance;
}

void Canvas::text(double x, double y, const std::string& text, double size, const Colour& colour, Align align, bool bold, bool up) {
  const double width = text_width(text, size, bold);
  const double shift = align == Align::left ? 0 : align == Align::center ? width / 2 : width;
  cairo_save(impl_->c);
  cairo_translate(impl_->c, x, y);
  if (up) cairo_rotate(impl_->c, -std::numbers::pi / 2);
  cairo_move_to(impl_->c, -shift, 0);
  impl_->colour(colour);
  cairo_show_text(impl_->c, text.c_str());
  cairo_restore(impl_->c);
}

void Canvas::image(const ImageU8& image, double x, double y, double width, double height, bool blocks) {
  require(image.channels == 3 || image.channels == 4, ErrorCode::bad_size, "a picture has three or four channels");
  cairo_surface_t* s = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, image.width, image.height);
  cairo_surface_flush(s);
  const int stride = cairo_image_surface_get_stride(s);
  unsigned char* data = cairo_image_surface_get_data(s);
  for (int v = 0; v < image.height; ++v) {
    auto* row = reinterpret_cast<std::uint32_t*>(data + static_cast<std::ptrdiff_t>(v) * stride);
    for (int u = 0; u < image.width; ++u) {
      const std::uint32_t a = image.channels == 4 ? image.at(u, v, 3) : 255;
      const auto channel = [&](int c) { return (image.at(u, v, c) * a + 127) / 255; };  // premultiplied
      row[u] = a << 24 | channel(0) << 16 | channel(1) << 8 | channel(2);
    }
  }
  cairo_surface_mark_dirty(s);
  cairo_save(impl_->c);
  cairo_translate(impl_->c, x, y);
  cairo_scale(impl_->c, width / image.width, height / image.height);
  cairo_set_source_surface(impl_->c, s, 0, 0);
  cairo_pattern_set_filter(cairo_get_source(impl_->c), blocks ? CAIRO_FILTER_NEAREST : CAIRO_FILTER_GOOD);
  cairo_pattern_set_extend(cairo_get_source(impl_->c), CAIRO_EXTEND_PAD);
  cairo_rectangle(impl_->c, 0, 0, image.width, image.height);
  cairo_fill(impl_->c);
  cairo_restore(impl_->c);
  cairo_surface_destroy(s);
}

void Canvas::clip(double x, double y, double width, double height) {
  cairo_save(impl_->c);
  cairo_rectangle(impl_->c, x, y, width, height);
  cairo_clip(impl_->c);
}

void Canvas::unclip() { cairo_restore(impl_->c); }

void Canvas::save() {
  if (impl_->svg) {
    cairo_surface_finish(impl_->surface);
  } else {
    cairo_surface_write_to_png_stream(impl_->surface, append, &impl_->bytes);
  }
  const cairo_status_t status = cairo_surface_status(impl_->surface);
  require(status == CAIRO_STATUS_SUCCESS && cairo_status(impl_->c) == CAIRO_STATUS_SUCCESS, ErrorCode::internal,
          std::string("drawing failed: ") + cairo_status_to_string(status));
  std::ofstream out(impl_->file, std::ios::binary);
  out.write(impl_->bytes.data(), static_cast<std::streamsize>(impl_->bytes.size()));
  out.close();
  require(!out.fail(), ErrorCode::io, "cannot write " + impl_->file + "; choose a folder that exists and may be written");
}

void require_writable(const std::string& file) {
  require(std::ofstream(file, std::ios::binary | std::ios::app).good(), ErrorCode::io, "cannot write " + file + "; choose a folder that exists and may be written");
}

Colour viridis(double share) {
  static constexpr std::array<std::array<double, 3>, 9> kStops{{{0.267, 0.005, 0.329},
                                                                {0.279, 0.175, 0.483},
                                                                {0.230, 0.322, 0.546},
                                                                {0.173, 0.449, 0.558},
                                                                {0.128, 0.567, 0.551},
                                                                {0.158, 0.684, 0.502},
                                                                {0.369, 0.789, 0.383},
                                                                {0.678, 0.864, 0.190},
                                                                {0.993, 0.906, 0.144}}};
  const double at = std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double w = at - static_cast<double>(i);
  const auto mix = [&](int c) { return (1 - w) * kStops[i][c] + w * kStops[i + 1][c]; };
  return {mix(0), mix(1), mix(2), 1};
}

}  // namespace periplus::nbv
