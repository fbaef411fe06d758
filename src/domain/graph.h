/* The graph of occupied ownership bricks: what a partitioner cuts. Local, for rank 0.
 *
 * A vertex is a brick with fluid in it or behind one of its faces, or bricks without that follow each other
 * and lie in one cube of HC_GRAPH_MERGED: walls far from water, of which there may be many more, weigh little
 * together. */
#ifndef HC_GRAPH_H
#define HC_GRAPH_H

#include "bricks.h"

#include <metis.h>

/* Compressed rows, as METIS takes them. A vertex weighs what its particles cost, an edge what a cut between
 * its bricks would make ghosts. */
enum { HC_GRAPH_FACES = 6, HC_GRAPH_MERGED_BITS = 2, HC_GRAPH_MERGED = 1 << HC_GRAPH_MERGED_BITS };

typedef struct hc_graph {
  idx_t count, *start, *adjacent, *vertex_weight, *edge_weight;
  int32_t *first; /* vertex v is bricks [first[v], first[v + 1]) */
} hc_graph;

/* Bricks that share a face are adjacent, across periodic borders as well. (With those that share an edge or a
 * corner too, divisions make no fewer ghosts and take more than twice as long: 12.0 and 12.3 % ghosts, 0.8
 * and 1.8 s for 64 parts of 10^6 bricks, bench_partition.) */
void hc_graph_init(hc_graph *graph, const hc_bricks *bricks, const hc_map *map, const hc_frame *frame);
void hc_graph_free(hc_graph *graph);

/* Sum of the weights of edges between different parts: part[k] of brick k. */
int64_t hc_graph_edge_cut(const hc_graph *graph, const int32_t *part);

/* Divides the graph by METIS (Karypis and Kumar 1998, "A fast and high quality multilevel scheme for
 * partitioning irregular graphs"), recursively and k-way, and keeps what cuts less among what is balanced.
 * Parts may be empty or disconnected, and there may be more of them than vertices; part[k] is that of brick
 * k. Returns the name of the way that was kept; null if METIS failed: then `part` means nothing. */
const char *hc_graph_divide(const hc_graph *graph, int parts, int32_t *part);

/* Groups the parts of a division (part[k] of brick k) by hosts, as many as these have ranks, so that little
 * is cut between groups: divides the graph of parts by METIS, then moves those that are too many where that
 * cuts least. */
void hc_graph_group(const hc_graph *graph, int parts, const int32_t *part, const hc_hosts *hosts,
                    int32_t *group);

#endif
