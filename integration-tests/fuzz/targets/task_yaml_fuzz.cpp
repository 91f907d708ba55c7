// Tasks: as they come from another computer, and with files that must be there.
#include "integration-tests/fuzz/expected_refusal.h"
#include "services/supervisor/task.h"

using namespace periplus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view yaml = fuzz::text(data, size);
  const auto task = fuzz::result_or_refusal([&] { return supervisor::parse_task(yaml, "task.yaml", std::nullopt); });
  fuzz::result_or_refusal([&] { return supervisor::parse_task(yaml, "task.yaml", "/usr/share"); });
  if (!task) return 0;
  const std::string written = task->yaml();
  const auto again = fuzz::must_read("a task was read and written", [&] { return supervisor::parse_task(written, "again.yaml", std::nullopt); });
  if (again.name != task->name || again.robot != task->robot || again.scene != task->scene || again.output != task->output || again.seed != task->seed ||
      again.dds != task->dds || again.instances != task->instances || again.box.size != task->box.size)
    fuzz::finding("a task that was read and written is another one:\n" + written);
  return 0;
}
