#include "services/supervisor/cli/run_view.h"

#include <gtest/gtest.h>

namespace periplus::supervisor::cli {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

RunEvent state(const std::string& name, double at_s, const std::string& cause = "") {
  RunEvent e;
  e.kind = "state";
  e.state = name;
  e.cause = cause;
  e.look = 1;
  e.wall_time_ns = static_cast<std::int64_t>(at_s * kSecond);
  return e;
}

RunEvent look(std::uint32_t number, double at_s, std::map<std::string, double> numbers) {
  RunEvent e;
  e.kind = "look";
  e.look = number;
  e.wall_time_ns = static_cast<std::int64_t>(at_s * kSecond);
  e.numbers = std::move(numbers);
  return e;
}

TEST(RunView, ARowShowsGainsCountsAndTheTimeOfEachStep) {
  RunView view;
  EXPECT_EQ(view.add(state("grab_images", 10)), "");
  EXPECT_EQ(view.add(state("process_images", 10.5)), "");
  EXPECT_EQ(view.under_way(12 * kSecond), "look 1: process images 2 s");
  EXPECT_EQ(view.add(look(1, 13, {{"found_gain_px", 41523.2}, {"known", 5321}, {"unknown", 120332}})),
            "   1               -        41 523        5 321      120 332       3.0  grab images 0.5 · process images 2.5\n");
  view.add(state("next_view", 13.5));
  view.add(state("walk", 15));
  const std::string second = view.add(look(2, 19, {{"predicted_gain_px", 100}, {"found_gain_px", -3}, {"known", 1}, {"unknown", 2}}));
  EXPECT_NE(second.find("6.0  record 0.5 · next view 1.5 · walk 4.0"), std::string::npos) << second;
  EXPECT_EQ(second.find("grab"), std::string::npos) << second;
  EXPECT_NE(second.find(" 100 "), std::string::npos) << second;
  EXPECT_NE(second.find(" -3 "), std::string::npos) << second;
}

TEST(RunView, AStateEnteredAgainIsTold) {
  RunView view;
  view.add(state("next_view", 1));
  view.add(state("generate_posture", 2));
  EXPECT_EQ(view.add(state("next_view", 3, "pose forbidden")), "      next view again: pose forbidden\n");
  const std::string row = view.add(look(2, 4, {}));
  EXPECT_NE(row.find("next view 2.0"), std::string::npos) << row;  // both times together
  view.add(state("next_view", 5));
  EXPECT_EQ(view.add(state("generate_posture", 6, "a new look")), "");
}

TEST(RunView, ANoteIsToldAndChangesNothingElse) {
  RunView view;
  view.add(state("prepare", 1));
  RunEvent note;
  note.kind = "note";
  note.state = "prepare";
  note.text = "object bunny is begun anew";
  EXPECT_EQ(view.add(note), "      object bunny is begun anew\n");
  EXPECT_EQ(view.under_way(3 * kSecond), "look 1: prepare 2 s");
}

TEST(RunView, TheEndSaysWhy) {
  RunView view;
  view.add(state("walk", 1));
  RunEvent end;
  end.kind = "end";
  end.exit_status = 4;
  end.cause = "10 poses forbidden";
  EXPECT_EQ(view.add(end), "no reachable view (4): 10 poses forbidden\n");
  EXPECT_EQ(view.under_way(2 * kSecond), "");
}

TEST(RunView, GroupsDigits) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1234567), "1 234 567");
  EXPECT_EQ(grouped(-1000), "-1 000");
  EXPECT_EQ(grouped(-0.2), "0");
}

}  // namespace
}  // namespace periplus::supervisor::cli
