#include "surfit/core/robust_kernel.h"

#include "core/named_values.h"

namespace surfit {
namespace {

constexpr NamedValue<RobustKernelType> kTypes[] = {
    {"none", RobustKernelType::kNone},
    {"huber", RobustKernelType::kHuber},
    {"tukey", RobustKernelType::kTukey},
    {"geman_mcclure", RobustKernelType::kGemanMcClure},
    {"student_t", RobustKernelType::kStudentT}};

}  // namespace

std::vector<std::string> RobustKernelNames() { return NamesOf(kTypes); }

RobustKernelType RobustKernelTypeFromName(const std::string& name) {
  return ValueOf("kernel", name, kTypes);
}

std::string ToString(RobustKernelType type) { return NameOf(type, kTypes); }

}  // namespace surfit
