#include "services/supervisor/cli/shared_memory.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <unistd.h>

#include <fstream>

namespace periplus::supervisor::cli {
namespace {

class SharedMemory : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("periplus_shm_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void make(const std::string& name) { std::ofstream(folder_ / name) << "some bytes"; }
  std::filesystem::path folder_;
};

TEST_F(SharedMemory, RemovesWhatNobodyUses) {
  for (const char* name : {"fastrtps_0123456789abcdef", "fastrtps_0123456789abcdef_el", "fastrtps_port7412", "sem.fastrtps_port7412_mutex", "other"}) make(name);
  EXPECT_EQ(shared_memory_leftovers(folder_).size(), 4u);
  EXPECT_EQ(clean_shared_memory(folder_), 4);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "other"));
  EXPECT_EQ(clean_shared_memory(folder_), 0);
}

TEST_F(SharedMemory, LeavesMappedFilesAndTheirCompanions) {
  for (const char* name : {"fastrtps_port7412", "fastrtps_port7412_el", "sem.fastrtps_port7412_mutex", "fastrtps_dead"}) make(name);
  const int fd = ::open((folder_ / "fastrtps_port7412").c_str(), O_RDWR);
  void* memory = ::mmap(nullptr, 4096, PROT_READ, MAP_SHARED, fd, 0);
  ::close(fd);
  ASSERT_NE(memory, MAP_FAILED);
  EXPECT_EQ(clean_shared_memory(folder_), 1);
  ::munmap(memory, 4096);
  EXPECT_EQ(clean_shared_memory(folder_), 3);
}

TEST_F(SharedMemory, RemovesWhatOnlyAProcessThatLeftTheBusStillMaps) {
  make("fastrtps_dead");
  const int fd = ::open((folder_ / "fastrtps_dead").c_str(), O_RDWR);
  void* memory = ::mmap(nullptr, 4096, PROT_READ, MAP_SHARED, fd, 0);
  ::close(fd);
  ASSERT_NE(memory, MAP_FAILED);
  EXPECT_EQ(clean_shared_memory(folder_), 0);
  EXPECT_EQ(clean_shared_memory(folder_, OwnMappings::unused), 1);
  ::munmap(memory, 4096);
}

TEST_F(SharedMemory, LeavesWhatIsLocked) {
  make("fastrtps_a");
  make("fastrtps_a_el");
  const int fd = ::open((folder_ / "fastrtps_a_el").c_str(), O_RDWR);
  ASSERT_EQ(::flock(fd, LOCK_SH), 0);
  EXPECT_EQ(clean_shared_memory(folder_), 0);
  ::close(fd);
  EXPECT_EQ(clean_shared_memory(folder_), 2);
}

TEST_F(SharedMemory, KnowsItsSize) {
  EXPECT_GT(shared_memory_size(folder_).total_bytes, 0u);
  EXPECT_EQ(shared_memory_size("/no/such/folder").total_bytes, 0u);
  EXPECT_TRUE(shared_memory_leftovers("/no/such/folder").empty());
}

}  // namespace
}  // namespace periplus::supervisor::cli
