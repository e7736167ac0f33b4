"""Figures and tables of the papers, published and reproduced: Table 1 identified from all six of its distances.

`table1` fits creep curve, levels and law; `adhesion_based` has figures and tables of that paper; `pages` writes the
results into docs/papers.
"""
