// Looking more than one view ahead: the next view is chosen for what it shows and for what the views after it can still add.
// Two views that each show a half can be worth more than the one that shows the most and leaves two small rests.
#pragma once

#include <cstdint>
#include <vector>

namespace periplus::nbv {

struct LookaheadSettings {
  int depth = 1;          // views that count, the next one included; 1..3, 1: no look ahead
  double discount = 0.9;  // what a view later is worth, against the same now
  double within = 0.15;   // only views whose own value is within this share of the best one's may come next
  int candidates = 24;    // the best by their own value that are considered, 2..64

  bool operator==(const LookaheadSettings&) const = default;
  // Throws Error(bad_input) naming the value and its range.
  void check() const;
};

// A candidate for the next view.
struct ViewPromise {
  double value = 0;                   // of taking it next: the weights of what it shows, less its penalties (-f_e)
  std::vector<std::uint32_t> voxels;  // what it shows; each once
};

struct LookaheadChoice {
  int first = -1;                     // index of the view to take next
  std::vector<int> then;              // the best views after it, in their order
  double total = 0;                   // value + discount * what the second adds + discount^2 * what the third adds
};

// `weights` by voxel; empty: 1 each. A later view adds the weights of those of its voxels that no view before it shows. Exact over
// all sequences of candidates; equal ones are decided for the candidate that stands first. Throws Error(bad_input) if there is no
// candidate.
LookaheadChoice look_ahead(const std::vector<ViewPromise>& candidates, const std::vector<float>& weights,
                           const LookaheadSettings& settings);

}  // namespace periplus::nbv
