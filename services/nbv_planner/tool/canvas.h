// A drawing that becomes a PNG or an SVG file, whichever the file's name says. Cairo behind it. The origin is the upper left
// corner, y points down, the unit is a pixel.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "common/geometry/image.h"

namespace periplus::nbv {

struct Colour {
  double r = 0, g = 0, b = 0, a = 1;  // 0..1
  Colour with_alpha(double alpha) const { return {r, g, b, alpha}; }
};

enum class Align { left, center, right };

class Canvas {
 public:
  // White. Throws Error(bad_input) unless the name ends in .png or .svg, Error(io) if the file cannot be written.
  Canvas(const std::string& file, double width, double height);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  void line(const std::vector<Eigen::Vector2d>& points, const Colour& colour, double width, bool dashed = false);
  void fill(const std::vector<Eigen::Vector2d>& polygon, const Colour& colour);
  void rectangle(double x, double y, double width, double height, const Colour& colour, double line_width);
  void disc(const Eigen::Vector2d& center, double radius, const Colour& colour);
  // `y` is the base line; `size` the height of the font. `up`: turned to be read from below upwards.
  void text(double x, double y, const std::string& text, double size, const Colour& colour = {}, Align align = Align::left,
            bool bold = false, bool up = false);
  double text_width(const std::string& text, double size, bool bold = false) const;
  // rgb (3) or rgb with opacity (4 channels); smoothed where it is shrunk, `blocks` keeps pixels as squares.
  void image(const ImageU8& image, double x, double y, double width, double height, bool blocks = false);
  // What follows is cut off outside the rectangle, until `unclip`.
  void clip(double x, double y, double width, double height);
  void unclip();

  // Writes the file. Throws Error(io).
  void save();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Throws Error(io) unless the file can be written; makes it where it is missing.
void require_writable(const std::string& file);

// Viridis (van der Walt and Smith 2015), 0 dark blue .. 1 yellow: even steps for the eye, also in grey.
Colour viridis(double share);

}  // namespace periplus::nbv
