// What `periplus calibrate` says: as text, as JSON, and as a picture of the worst image.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/geometry/image.h"
#include "services/vision_server/calibration.h"

namespace periplus::vision {

struct Calibrated {
  Chessboard board;
  bool metric = false;           // the square's side is known in metres; else lengths are in squares
  std::optional<PairFit> pair;   // exactly one of the two
  std::optional<CameraFit> camera;
  std::vector<std::string> files;  // written
};

// Index of the view, or pair, of the greatest error; of a pair the greater eye's counts.
std::size_t worst_view(const Calibrated& c);

std::string report_text(const Calibrated& c);
// Schema periplus-calibrate-1.
std::string report_json(const Calibrated& c);
// Of a refusal, same schema: `result` "refused", `reason`, `images` with `image` and `why`.
std::string refusal_json(const std::string& reason, const std::vector<ViewFault>& faults);

// PNG of view `n`, left eye beside right: corners found as green circles, reprojected as red crosses, and the error between as a
// yellow line 20 times its length. `images`: the raw ones, one or two.
std::string view_picture(const Calibrated& c, std::size_t n, const std::vector<ImageU8>& images);

}  // namespace periplus::vision
