// theory/travelling_family.cpp: systems and means at values of a parameter.
#include "theory/travelling_family.hpp"

#include <memory>
#include <optional>

namespace drover::theory {

namespace {
/// Newton's method asks for one value many times.
class Kept {
public:
    explicit Kept(std::function<model::Integrated(double)> at) : of_(std::move(at)) {}

    const model::Integrated& at(double parameter) {
        if (what_ && parameter == parameter_) return *what_;
        what_ = of_(parameter);
        what_->is_quiet = true;
        parameter_ = parameter;
        const model::TermSummary* placed = what_->equations.placed_term();
        require(placed == nullptr, placed == nullptr ? SourceLocation{} : placed->where,
                "the term {} depends on position or time; expected terms without: a travelling state has none",
                placed == nullptr ? "" : placed->text);
        return *what_;
    }

private:
    std::function<model::Integrated(double)> of_;
    std::optional<model::Integrated> what_;
    double parameter_ = 0.0;
};
}  // namespace

numerics::TravellingFamily travelling_family(const TravellingProblem& problem, Threads& threads) {
    const auto kept = std::make_shared<Kept>(problem.at);
    return {.system = [kept, line = problem.grid,
                       &threads](double value) { return model::system_of(kept->at(value), line, threads); },
            .mean =
                [kept](double value, int component) {
                    const model::Equations& here = kept->at(value).equations;
                    const int place = here.state_components()[static_cast<std::size_t>(component)];
                    return here.reference()[static_cast<std::size_t>(place)];
                },
            .parameter = problem.parameter};
}

}  // namespace drover::theory
