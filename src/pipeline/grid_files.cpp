#include "pipeline/grid_files.h"

#include "pipeline/csv_line.h"

namespace hymm::core {
namespace {

double megabytes(std::size_t bytes) { return 1e-6 * static_cast<double>(bytes); }

}  // namespace

void MapMemoryLog::add(const GridMemory& memory) {
  text_ += csvLine(',', memory.time_s, memory.ltrs, megabytes(memory.in_ltrs.unpacked_bytes),
                   megabytes(memory.in_ltrs.packed_bytes),
                   megabytes(memory.in_ltrs.packed_from_bytes), megabytes(memory.waiting_bytes));
  text_ += '\n';
}

std::string ltrsText(const std::vector<LtrTopology>& ltrs) {
  std::string text =
      "id,landmark_1,landmark_2,landmark_3,neighbour_12,neighbour_23,neighbour_31,alpha_cells,"
      "beta_cells,observations,shape_factor\n";
  for (const LtrTopology& ltr : ltrs) {
    const auto& l = ltr.landmark_ids;
    const auto& n = ltr.neighbours;
    text += csvLine(',', ltr.id, l[0], l[1], l[2], n[0], n[1], n[2], ltr.alpha_cells,
                    ltr.beta_cells, ltr.observations, ltr.shape_factor);
    text += '\n';
  }
  return text;
}

GridMemory memoryOf(const HybridMap& map, double time_s) {
  GridMemory memory;
  memory.time_s = time_s;
  const LtrMesh& mesh = map.partition().mesh();
  for (int ltr = 0; ltr < mesh.ltrEnd(); ++ltr) memory.ltrs += mesh.ltr(ltr).is_alive ? 1 : 0;
  memory.in_ltrs = map.ltrMemory();
  memory.waiting_bytes = map.waitingMemory().bytes();
  return memory;
}

}  // namespace hymm::core
