#include "apps/scan/scan_graph.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "loop_closure/correct_frames.h"
#include "loop_closure/edge_information.h"

namespace surfit {
namespace {

constexpr int kNoPart = -1;
// Nearly infinite information, for two fragments that share a frame. LoopInformation() adds the
// noise of loop closures.
const Matrix6d kExact = 1e12 * Matrix6d::Identity();
// Factor of the information of a cut edge. The edge still connects both halves for the solver.
constexpr double kCutInformation = 1e-9;
// Minimum number of links that a cut makes consistent. One link alone can be wrong.
constexpr std::size_t kMinCutLinks = 2;

// Smallest eigenvalue of the information of an edge. Rotations count in rad, translations in m.
double Certainty(const PoseGraphEdge& edge) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(edge.information, Eigen::EigenvaluesOnly)
      .eigenvalues()[0];
}

std::vector<int> FrameOfKeyframe(const RunPlaces& places) {
  std::vector<int> positions;
  for (const Keyframe& keyframe : places.keyframes) {
    const auto at =
        std::lower_bound(places.frames.begin(), places.frames.end(), keyframe.frame_index,
                         [](const PosedFrame& frame, int index) { return frame.index < index; });
    positions.push_back(static_cast<int>(at - places.frames.begin()));
  }
  return positions;
}

Rigid3d Blend(const Rigid3d& from, const Rigid3d& to, double share) {
  return {from.rotation.slerp(share, to.rotation).normalized(),
          (1 - share) * from.translation + share * to.translation};
}

}  // namespace

ScanGraph::ScanGraph(std::vector<std::optional<RunPlaces>> fragments, std::vector<int> recordings,
                     std::vector<GraphLink> links, const LoopOptions& options)
    : recordings_(std::move(recordings)), links_(std::move(links)), options_(options) {
  for (std::optional<RunPlaces>& places : fragments) {
    fragments_.emplace_back();
    if (places && !places->keyframes.empty()) fragments_.back() = {*std::move(places), {}, {}};
  }
}

// Connects two fragments by the middle one of their shared frames. std::nullopt without shared
// frames.
std::optional<ScanGraph::Connection> ScanGraph::Joint(std::size_t a, std::size_t b) const {
  if (!fragments_[a] || !fragments_[b]) return std::nullopt;
  const std::vector<PosedFrame>& of_a = fragments_[a]->places.frames;
  std::vector<std::pair<const PosedFrame*, const PosedFrame*>> shared;
  for (const PosedFrame& frame : fragments_[b]->places.frames) {
    const auto at =
        std::lower_bound(of_a.begin(), of_a.end(), frame.index,
                         [](const PosedFrame& other, int index) { return other.index < index; });
    if (at != of_a.end() && at->index == frame.index) shared.emplace_back(&*at, &frame);
  }
  if (shared.empty()) return std::nullopt;
  const auto [in_a, in_b] = shared[shared.size() / 2];
  Connection joint = {a, b, in_a->world_from_camera * in_b->world_from_camera.Inverse(), {}, 0};
  PoseGraphEdge edge;
  edge.a = static_cast<std::size_t>(in_a->keyframe);
  edge.b = static_cast<std::size_t>(in_b->keyframe);
  edge.a_from_b = fragments_[a]->places.keyframes[edge.a].world_from_camera.Inverse() *
                  joint.a_from_b * fragments_[b]->places.keyframes[edge.b].world_from_camera;
  edge.information = LoopInformation(kExact, options_.noise);
  joint.joint = edge;
  return joint;
}

// Returns connections of consecutive fragments, followed by links in order of decreasing overlap.
std::vector<ScanGraph::Connection> ScanGraph::Connections() const {
  std::vector<Connection> connections;
  for (std::size_t i = 0; i + 1 < fragments_.size(); ++i) {
    if (recordings_[i] != recordings_[i + 1]) continue;
    if (const auto joint = Joint(i, i + 1)) connections.push_back(*joint);
  }
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const GraphLink& link = links_[i];
    if (!link.is_rejected && fragments_[link.source] && fragments_[link.target]) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
    return links_[x].overlap_ratio > links_[y].overlap_ratio;
  });
  for (const std::size_t i : order) {
    const GraphLink& link = links_[i];
    const Keyframe& to = fragments_[link.target]->places.keyframes[link.target_keyframe];
    const Keyframe& from = fragments_[link.source]->places.keyframes[link.source_keyframe];
    connections.push_back(
        {link.target,
         link.source,
         to.world_from_camera * link.target_from_source * from.world_from_camera.Inverse(),
         {},
         i});
  }
  return connections;
}

std::vector<int> ScanGraph::Parts(const std::vector<Connection>& connections,
                                  std::vector<Rigid3d>* world_from_fragment) const {
  std::vector<int> parts;
  world_from_fragment->assign(fragments_.size(), Rigid3d());
  for (std::size_t i = 0; i < fragments_.size(); ++i) {
    parts.push_back(fragments_[i] ? static_cast<int>(i) : kNoPart);
  }
  for (const Connection& connection : connections) {
    const int to = parts[connection.a], from = parts[connection.b];
    if (to == from) continue;
    const Rigid3d moved = (*world_from_fragment)[connection.a] * connection.a_from_b *
                          (*world_from_fragment)[connection.b].Inverse();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i] != from) continue;
      parts[i] = to;
      (*world_from_fragment)[i] = moved * (*world_from_fragment)[i];
    }
  }
  return parts;
}

int ScanGraph::LargestPart(const std::vector<int>& parts) const {
  std::map<int, std::size_t> frames;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (fragments_[i]) frames[parts[i]] += fragments_[i]->places.frames.size();
  }
  int largest = kNoPart;
  for (const auto& [part, count] : frames) {
    if (largest == kNoPart || count > frames[largest]) largest = part;
  }
  return largest;
}

std::optional<ScanGraph::Solution> ScanGraph::SolveWith(
    const std::vector<FragmentCut>& cuts) const {
  const std::vector<Connection> connections = Connections();
  std::vector<Rigid3d> world_from_fragment;
  const std::vector<int> parts = Parts(connections, &world_from_fragment);
  const int largest = LargestPart(parts);
  Solution solution;
  PoseGraph& graph = solution.graph;
  solution.first_node.resize(fragments_.size());
  solution.first_edge.resize(fragments_.size());
  for (std::size_t i = 0; i < fragments_.size(); ++i) {
    if (parts[i] != largest || !fragments_[i]) continue;
    solution.first_node[i] = graph.poses.size();
    solution.first_edge[i] = graph.edges.size();
    for (const Keyframe& keyframe : fragments_[i]->places.keyframes) {
      graph.poses.push_back({static_cast<std::int64_t>(graph.poses.size()),
                             world_from_fragment[i] * keyframe.world_from_camera, false});
    }
    for (PoseGraphEdge edge : fragments_[i]->places.edges) {
      edge.a += solution.first_node[i], edge.b += solution.first_node[i];
      graph.edges.push_back(edge);
    }
  }
  for (const FragmentCut& cut : cuts) {
    if (parts[cut.fragment] != largest) continue;
    graph.edges[solution.first_edge[cut.fragment] + cut.edge].information *= kCutInformation;
  }
  std::map<std::size_t, std::size_t> link_of_edge;
  for (const Connection& connection : connections) {
    if (parts[connection.a] != largest) continue;
    PoseGraphEdge edge;
    if (connection.joint) {
      edge = *connection.joint;
    } else {
      const GraphLink& link = links_[connection.link];
      edge.a = static_cast<std::size_t>(link.target_keyframe);
      edge.b = static_cast<std::size_t>(link.source_keyframe);
      edge.a_from_b = link.target_from_source;
      edge.information = LoopInformation(link.information, options_.noise);
      edge.loop = true;
      link_of_edge[graph.edges.size()] = connection.link;
    }
    edge.a += solution.first_node[connection.a], edge.b += solution.first_node[connection.b];
    graph.edges.push_back(edge);
  }
  const PoseGraphSummary summary = OptimizePoseGraph(options_.graph, &graph);
  if (!summary.Succeeded()) return std::nullopt;
  solution.is_wrong.assign(graph.edges.size(), false);
  for (const std::size_t edge : summary.outlier_edges) {
    solution.is_wrong[edge] = true;
    const auto link = link_of_edge.find(edge);
    if (link != link_of_edge.end()) solution.rejected_links.push_back(link->second);
  }
  std::sort(solution.rejected_links.begin(), solution.rejected_links.end());
  return solution;
}

// Connections of a fragment divide its keyframes into intervals. All edges of an interval explain
// the same contradictions. One end of the interval must have a rejected link.
std::vector<FragmentCut> ScanGraph::PossibleCuts(const Solution& solution) const {
  std::vector<FragmentCut> cuts;
  const std::vector<Connection> connections = Connections();
  for (std::size_t f = 0; f < fragments_.size(); ++f) {
    if (!fragments_[f]) continue;
    std::set<std::size_t> ends;  // connected keyframes
    std::size_t rejected = 0;
    for (const Connection& connection : connections) {
      if (connection.joint) {
        if (connection.a == f) ends.insert(connection.joint->a);
        if (connection.b == f) ends.insert(connection.joint->b);
        continue;
      }
      const GraphLink& link = links_[connection.link];
      if (link.source == f) ends.insert(static_cast<std::size_t>(link.source_keyframe));
      if (link.target == f) ends.insert(static_cast<std::size_t>(link.target_keyframe));
      if (link.source != f && link.target != f) continue;
      rejected += std::binary_search(solution.rejected_links.begin(), solution.rejected_links.end(),
                                     connection.link);
    }
    if (rejected < kMinCutLinks) continue;
    const RunPlaces& places = fragments_[f]->places;
    std::map<std::size_t, std::size_t> weakest;  // edge by the end of its interval
    for (std::size_t e = 0; e < places.edges.size(); ++e) {
      const PoseGraphEdge& edge = places.edges[e];
      const auto end = ends.lower_bound(edge.b);
      if (edge.loop || edge.b != edge.a + 1 || end == ends.end() || edge.a < *ends.begin())
        continue;
      const auto [at, is_new] = weakest.emplace(*end, e);
      if (!is_new && Certainty(edge) < Certainty(places.edges[at->second])) at->second = e;
    }
    for (const auto& [end, e] : weakest) {
      const PoseGraphEdge& edge = places.edges[e];
      cuts.push_back(
          {f, e, 0, places.keyframes[edge.a].frame_index, places.keyframes[edge.b].frame_index});
    }
  }
  return cuts;
}

bool ScanGraph::Cut(Solution* solution) {
  const std::size_t before = solution->rejected_links.size();
  std::optional<Solution> best;
  FragmentCut best_cut;
  for (FragmentCut cut : PossibleCuts(*solution)) {
    std::vector<FragmentCut> cuts = cuts_;
    cuts.push_back(cut);
    std::optional<Solution> with_cut = SolveWith(cuts);
    if (!with_cut || with_cut->rejected_links.size() + kMinCutLinks > before) continue;
    if (best && with_cut->rejected_links.size() >= best->rejected_links.size()) continue;
    cut.links = before - with_cut->rejected_links.size();
    best = std::move(with_cut);
    best_cut = cut;
  }
  if (!best) return false;
  *solution = *std::move(best);
  cuts_.push_back(best_cut);
  return true;
}

bool ScanGraph::Solve() {
  std::optional<Solution> solution = SolveWith({});
  if (!solution) return false;
  while (Cut(&*solution)) continue;
  std::stable_sort(cuts_.begin(), cuts_.end(), [](const FragmentCut& a, const FragmentCut& b) {
    return a.fragment < b.fragment;
  });
  Take(*solution);
  return true;
}

void ScanGraph::Take(const Solution& solution) {
  for (const std::size_t link : solution.rejected_links) links_[link].is_rejected = true;
  // The rejection of outlier links can disconnect further fragments.
  std::vector<Rigid3d> world_from_fragment;
  const std::vector<int> parts = Parts(Connections(), &world_from_fragment);
  const int left = LargestPart(parts);
  for (std::size_t i = 0; i < fragments_.size(); ++i) {
    if (!fragments_[i] || parts[i] != left) continue;
    for (std::size_t k = 0; k < fragments_[i]->places.keyframes.size(); ++k) {
      fragments_[i]->solved.push_back(
          solution.graph.poses[solution.first_node[i] + k].world_from_pose);
    }
    const std::vector<PoseGraphEdge>& edges = fragments_[i]->places.edges;
    for (std::size_t e = 0; e < edges.size(); ++e) {
      if (edges[e].loop && !solution.is_wrong[solution.first_edge[i] + e]) {
        fragments_[i]->kept_loops.push_back(edges[e]);
      }
    }
  }
  // Corrections are not interpolated across a cut.
  for (const FragmentCut& cut : cuts_) {
    for (PosedFrame& frame : fragments_[cut.fragment]->places.frames) {
      if (frame.index >= cut.after) ++frame.segment;
    }
  }
  for (GraphLink& link : links_) {
    link.is_rejected |= IsDisconnected(link.source) || IsDisconnected(link.target);
  }
}

std::optional<Rigid3d> ScanGraph::Residual(const GraphLink& link) const {
  const auto &source = fragments_[link.source], &target = fragments_[link.target];
  if (source->solved.empty() || target->solved.empty()) return std::nullopt;
  return link.target_from_source.Inverse() * target->solved[link.target_keyframe].Inverse() *
         source->solved[link.source_keyframe];
}

std::vector<PosedFrame> ScanGraph::Frames(int recording) const {
  std::vector<PosedFrame> all;
  for (std::size_t i = 0; i < fragments_.size(); ++i) {
    const std::optional<GraphFragment>& fragment = fragments_[i];
    if (recordings_[i] != recording || !fragment || fragment->solved.empty()) continue;
    std::vector<PosedFrame> frames = fragment->places.frames;
    std::vector<Rigid3d> new_from_old;
    for (std::size_t k = 0; k < fragment->solved.size(); ++k) {
      new_from_old.push_back(fragment->solved[k] *
                             fragment->places.keyframes[k].world_from_camera.Inverse());
    }
    const FrameCorrections corrections =
        CorrectionsOfFrames(frames, FrameOfKeyframe(fragment->places), new_from_old);
    const int begin = frames.front().index, end = all.empty() ? begin : all.back().index;
    for (PosedFrame& frame : frames) {
      frame.world_from_camera = corrections.At(frame.index) * frame.world_from_camera;
      const auto at =
          std::lower_bound(all.begin(), all.end(), frame.index,
                           [](const PosedFrame& other, int index) { return other.index < index; });
      if (at == all.end()) {
        all.push_back(frame);
      } else if (at->index == frame.index) {
        const double share = (frame.index - begin + 1.) / (end - begin + 2.);
        at->world_from_camera = Blend(at->world_from_camera, frame.world_from_camera, share);
      } else {
        all.insert(at, frame);
      }
    }
  }
  return all;
}

}  // namespace surfit
