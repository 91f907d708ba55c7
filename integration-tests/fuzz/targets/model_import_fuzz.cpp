// OctoMap's trees and PCL's clouds as models. Each input goes to both readers: their first lines tell them apart.
#include "common/object_model/model_export.h"
#include "common/object_model/model_import.h"
#include "integration-tests/fuzz/expected_refusal.h"

using namespace periplus;

namespace {

// A small one is written and read again; the large ones would take the time of many.
void check(const object_model::ObjectModel& model) {
  const auto& g = model.grid().geometry();
  if (g.size.cast<double>().prod() > 4096) return;
  const std::string bt = object_model::export_model(model, "bt");
  const auto again = fuzz::must_read("an imported model was written as .bt", [&] { return object_model::import_bt(bt, "again"); });
  if (again.grid().counts().known != model.grid().counts().known) fuzz::finding("an imported model has other known voxels after .bt");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view file = fuzz::text(data, size);
  if (const auto model = fuzz::result_or_refusal([&] { return object_model::import_bt(file, "thing"); })) check(*model);
  if (const auto model = fuzz::result_or_refusal([&] { return object_model::import_pcd(file, "thing", 0.05); })) check(*model);
  return 0;
}
