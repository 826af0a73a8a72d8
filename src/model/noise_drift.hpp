// model/noise_drift.hpp: what noise in the sense of Stratonovich adds to the rates.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "model/compiled.hpp"
#include "model/summands.hpp"

namespace drover::model {

/// The drift of summands B(a) xi that multiply noise: the mean of half the change of B(a) xi along B(a) xi, with white
/// noise of the modes of Model::noise_moment.
/// Source: C. Gardiner, Stochastic Methods, 4th ed. (2009), section 4.3.6.
class NoiseDrift {
public:
    NoiseDrift(Algebra& algebra, const CompiledEquations& equations) : algebra_(algebra), c_(equations) {}

    /// Adds a summand of a field whose mass, as far as it is no factor of the summand, is a number; NaN: it varies.
    /// Throws an input Error for a field without divergence, a mass that varies, and strengths that depend on a field
    /// in balance.
    void add(const Summand& summand, double mass);
    /// What is added to the rates of a field, by components; empty without summands of it.
    std::vector<Component> of(std::size_t field);
    /// "drift of phi xi"
    const std::string& text(std::size_t field) const { return texts_.at(field); }

private:
    bool is_noise(const LinearForm& form) const;
    double covariance(const LinearForm& f, const LinearForm& g) const;
    int change_of(int slot);
    int mean_of(int square);

    Algebra& algebra_;
    const CompiledEquations& c_;
    std::map<int, Component> rates_;  // of components: linear in white noises, the components beyond those of fields
    std::map<std::size_t, std::string> texts_;
};

}  // namespace drover::model
