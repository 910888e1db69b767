"""Refinement: transitions are chosen by the largest errors that they survive (the paper's future
work (ii)).
"""

from dataclasses import replace

from wholearm_ros.planner.candidates import transition_options
from wholearm_ros.planner.evaluation import Candidate, Evaluation
from wholearm_ros.planner.stopwatch import VERIFY
from wholearm_ros.rollout.perturbed_samples import PerturbedSample, build_perturbed_samples
from wholearm_ros.rollout.verification import parallel_rollouts, verify
from wholearm_ros.trajectory.execution_options import ExecutionOptions
from wholearm_ros.trajectory.main_trajectory import generate


def refine_transitions(best: Candidate, evaluation: Evaluation) -> Candidate:
    """The candidate with the transitions that survive most stress samples, of all the ways to cross
    where the torque ranges part, if it is no worse on the samples of `evaluation`: the start
    and the size of the extra torque are thus chosen by simulation.
    """
    parted = any(not t['condition_2'] for t in best.trajectory.transitions)
    options = _transition_choices(best, evaluation.request.transition)
    if not parted or len(options) < 2 or evaluation.watch.late():
        return best
    with evaluation.watch.stage(VERIFY):
        for execution in _by_stress(best, evaluation, options):
            plan = best.plan.with_execution(execution.to_dict())
            if plan.id == best.plan.id:
                return best
            trajectory = generate(evaluation.scenario, plan, execution)
            verification = verify(trajectory, evaluation.samples, evaluation.controls)
            if verification.success_rate >= best.success_rate:
                return Candidate(plan, trajectory, verification)
    return best


def _transition_choices(best: Candidate, wanted: str) -> list[ExecutionOptions]:
    """The execution of `best` with each of the ways to make its transitions."""
    chosen = ExecutionOptions.from_dict(best.plan.execution)
    return [
        replace(
            chosen,
            transition=way.transition,
            extra_torque=way.extra_torque,
            dynamic_lead=way.dynamic_lead,
        )
        for way in transition_options(wanted)
    ]


def _by_stress(
    best: Candidate, evaluation: Evaluation, options: list[ExecutionOptions]
) -> list[ExecutionOptions]:
    """The options, those first that most stress samples survive; options that all of them survive
    end the comparison.
    """
    samples, survivors = _stress_samples(evaluation), []
    for execution in options:
        plan = best.plan.with_execution(execution.to_dict())
        trajectory = generate(evaluation.scenario, plan, execution)
        done = parallel_rollouts(trajectory, samples, evaluation.controls)
        survivors.append(sum(r.success for r in done))
        if survivors[-1] == len(samples):
            break
    return [options[k] for k in sorted(range(len(survivors)), key=lambda k: -survivors[k])]


def _stress_samples(evaluation: Evaluation) -> list[PerturbedSample]:
    """Samples more strongly perturbed than those of `evaluation`."""
    r, scenario = evaluation.request, evaluation.scenario
    stressed = (
        build_perturbed_samples(scenario, r.stress_samples, level, r.seed, r.hand_errors)
        for level in r.stress_levels
    )
    return [sample for samples in stressed for sample in samples[1:]]
