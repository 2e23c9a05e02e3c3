#include "bench/run/reference_rows.h"

#include "bench/contacts/image_contacts.h"
#include "bench/score/metric_summary.h"
#include "forward/data/dataset_file.h"

namespace ertbench {

namespace {

/// The scored frames of one test set.
struct References {
  std::vector<FrameMetrics> truth;
  std::vector<FrameMetrics> untouched;
  Truth known;
};

References score_references(const Sensor& sensor, const DatasetFile& set,
                            const ContactSettings& settings) {
  References out;
  out.known = set.truth();
  const ContactDistances distances = settings.distances(sensor);
  const ContactRule rule = settings.rule();
  ContactReader reader(sensor);
  std::vector<FoundContact> found;
  const Eigen::RowVectorXd nothing = Eigen::RowVectorXd::Zero(sensor.pixels());
  constexpr std::uint64_t block = 256;
  for (std::uint64_t first = 0; first < set.size(); first += block) {
    const std::uint64_t count = std::min(block, set.size() - first);
    const Images images = set.conductivity(first, count);
    const std::vector<Scene> scenes = set.scenes(first, count);
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::RowVectorXd image = images.row(static_cast<Eigen::Index>(i));
      const Eigen::RowVectorXd change = image.array() - sensor.background;
      reader.read(rule, change, found);
      out.truth.push_back(frame_metrics(sensor, image, change, scenes[i], {found, distances}));
      out.untouched.push_back(frame_metrics(sensor, image, nothing, scenes[i], {{}, distances}));
    }
  }
  return out;
}

ResultRow row_of(const std::string& label, const DatasetSpec& test,
                 const std::vector<FrameMetrics>& frames, const Truth& known) {
  ResultRow row;
  row.label = row.type = label;
  row.dataset = test.name;
  row.frames = static_cast<int>(frames.size());
  row.metrics = summarise(frames, known);
  return row;
}

}  // namespace

std::vector<ResultRow> reference_rows(const Sensor& sensor, std::span<const DatasetSpec> tests,
                                      const ContactSettings& contacts, const Cache& cache) {
  std::vector<ResultRow> rows;
  for (const DatasetSpec& test : tests) {
    const References references = score_references(sensor, cache.open_dataset(test), contacts);
    rows.push_back(row_of("truth", test, references.truth, references.known));
    rows.push_back(row_of("no-contact", test, references.untouched, references.known));
  }
  return rows;
}

}  // namespace ertbench
