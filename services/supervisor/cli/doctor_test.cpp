#include "services/supervisor/cli/doctor.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "services/supervisor/cli/launcher.h"

namespace periplus::supervisor::cli {
namespace {

using Grade = Finding::Grade;

class Doctor : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("periplus_doctor_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  static const Finding* find(const std::vector<Finding>& all, const std::string& part) {
    const auto at = std::find_if(all.begin(), all.end(), [&](const Finding& f) { return f.text.find(part) != std::string::npos; });
    return at == all.end() ? nullptr : &*at;
  }
  std::filesystem::path folder_;
};

TEST_F(Doctor, ReadsLdd) {
  const auto all = parse_ldd("\tlinux-vdso.so.1 (0x00007ffc)\n\tlibfastrtps.so.2.9 => /usr/lib/libfastrtps.so.2.9 (0x00007f)\n\tlibddsc.so.0 => not found\n");
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].name, "libfastrtps.so.2.9");
  EXPECT_EQ(all[0].path, "/usr/lib/libfastrtps.so.2.9");
  EXPECT_EQ(all[1].path, "not found");
}

TEST_F(Doctor, NamesAbsentPrograms) {
  std::filesystem::copy("/bin/true", folder_ / "periplus-simulator");
  const auto all = check_programs(folder_);
  const Finding* absent = find(all, "periplus-walk-planner");
  ASSERT_TRUE(absent);
  EXPECT_EQ(absent->grade, Grade::warning);
  EXPECT_EQ(absent->text.find("periplus-simulator"), std::string::npos);
}

TEST_F(Doctor, FindsLeftovers) {
  EXPECT_TRUE(find(check_shared_memory(folder_), "none of killed"));
  std::ofstream(folder_ / "fastrtps_12") << "x";
  const auto all = check_shared_memory(folder_);
  const Finding* leftovers = find(all, "--clean");
  ASSERT_TRUE(leftovers);
  EXPECT_EQ(leftovers->grade, Grade::warning);
}

TEST_F(Doctor, WarnsOfSmallSocketBuffers) {
  std::ofstream(folder_ / "rmem_max") << "212992\n";
  std::ofstream(folder_ / "wmem_max") << "8388608\n";
  const auto all = check_socket_buffers(folder_);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].grade, Grade::warning);
  EXPECT_NE(all[0].text.find("sysctl -w net.core.rmem_max=4194304"), std::string::npos);
  EXPECT_EQ(all[1].grade, Grade::good);
}

TEST_F(Doctor, FindsTwoSupervisorsAndWrongClocks) {
  ServiceRow row;
  row.service = "supervisor";
  row.instance = "supervisor-a-1";
  row.host = "a";
  row.state = 1;
  EXPECT_FALSE(find(check_domain({row}, 42), "stop all but one"));
  ServiceRow other = row;
  other.instance = "supervisor-b-1";
  other.clock_ahead_s = -0.25;
  const auto all = check_domain({row, other}, 42);
  ASSERT_TRUE(find(all, "stop all but one"));
  EXPECT_EQ(find(all, "stop all but one")->grade, Grade::bad);
  ASSERT_TRUE(find(all, "-250 ms off"));
  EXPECT_EQ(find(all, "-250 ms off")->grade, Grade::bad);
  other.age_s = 20;
  EXPECT_FALSE(find(check_domain({row, other}, 42), "stop all but one"));
  EXPECT_TRUE(find(check_domain({}, 42), "nobody"));
  EXPECT_NE(to_text(all).find("BAD  clocks"), std::string::npos);
}

}  // namespace
}  // namespace periplus::supervisor::cli
