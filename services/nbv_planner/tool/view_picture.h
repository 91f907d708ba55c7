// A planned view as a picture: the object's voxels and the obstacles from the side and from above, the poses that the search
// looked at, coloured by f_e, the chosen view among them, and what it sees.
#pragma once

#include <string>
#include <vector>

#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/tool/canvas.h"
#include "services/nbv_planner/tool/voxel_view.h"

namespace periplus::nbv {

// A pose that the search evaluated.
struct LookedAt {
  Pose X_WC = Pose::Identity();  // left eye
  double f_e = 0;
  bool feasible = true;          // no hard constraint is violated
};

struct ViewPicture {
  std::string title, subtitle;
  std::vector<LookedAt> candidates;
  Pose X_WC = Pose::Identity();  // the chosen left eye
  double f_e = 0;
  std::vector<std::pair<std::string, std::string>> facts;  // a table of what was found
};

// 1600 x 1080 pixels. Throws as Canvas.
void draw_view(const std::string& file, const Evaluator& evaluator, const ViewPicture& picture);

// The side view alone, into a rectangle: voxels, solids, floor and the poses given, as in Fig. 3.4, top left.
struct SideViewPose {
  Pose X_WC = Pose::Identity();
  Colour colour;
  double size = 0.1;             // from the eye to the far end of the drawn pyramid [m]
  double sight = 0;              // the same for thin lines along what it sees; 0: none
};
void draw_side_view(Canvas& canvas, const Situation& situation, const std::vector<SideViewPose>& poses, double azimuth, double x,
                    double y, int width, int height);

}  // namespace periplus::nbv
