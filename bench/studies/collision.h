#pragma once

#include "bench/studies/study.h"

namespace ertbench {

class Collision : public StudyResult {
 public:
  explicit Collision(const StudyInput& input);

  nlohmann::json summary() const override;
  std::vector<ReportSection> report(const std::string& title,
                                    const std::filesystem::path& folder) const override;
};

}  // namespace ertbench
