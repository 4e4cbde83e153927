#include "surfit/core/robust_kernel.h"

#include "core/named_values.h"
#include "surfit/core/options.h"

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

std::string ToString(RobustKernelType type) { return NameOf(type, kTypes); }

static std::string OptionToText(const RobustKernelType& type) { return ToString(type); }

static void OptionFromText(const std::string& text, RobustKernelType* type) {
  for (const auto& [name, value] : kTypes) {
    if (text == name) {
      *type = value;
      return;
    }
  }
  throw InputError("one of: ", JoinNames(RobustKernelNames()));
}

void RobustKernel::Visit(OptionVisitor& v) {
  v.Add(type, "type", "robust kernel", OneOf(RobustKernelNames()), AsFlag("kernel"));
  v.Add(width, "width", "width of the robust kernel in sigmas", Positive());
}

}  // namespace surfit
