"""The papers that rules and bodies come from, as BibTeX.

A declaration names its source in words, `Liu et al. 2021, (5)`; a paper is cited by a model whose
sources have the paper's words in them. A rule from elsewhere brings its own entries in `bibtex`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from agents.models.model import Model


class Paper(NamedTuple):
    """A source of models."""

    pattern: str
    """Pattern of the words by which declarations name it."""
    bibtex: str


PAPERS = (
    Paper(
        r"Vicsek et al\. 1995",
        r"""@article{vicsek1995,
  author  = {Vicsek, Tam{\'a}s and Czir{\'o}k, Andr{\'a}s and Ben-Jacob, Eshel and Cohen, Inon and
             Shochet, Ofer},
  title   = {Novel Type of Phase Transition in a System of Self-Driven Particles},
  journal = {Physical Review Letters},
  volume  = {75},
  number  = {6},
  pages   = {1226--1229},
  year    = {1995},
  doi     = {10.1103/PhysRevLett.75.1226},
}""",
    ),
    Paper(
        r"Grégoire and Chaté 2004",
        r"""@article{gregoirechate2004,
  author  = {Gr{\'e}goire, Guillaume and Chat{\'e}, Hugues},
  title   = {Onset of Collective and Cohesive Motion},
  journal = {Physical Review Letters},
  volume  = {92},
  number  = {2},
  pages   = {025702},
  year    = {2004},
  doi     = {10.1103/PhysRevLett.92.025702},
}""",
    ),
    Paper(
        r"Ballerini et al\. 2008",
        r"""@article{ballerini2008,
  author  = {Ballerini, M. and Cabibbo, N. and Candelier, R. and Cavagna, A. and Cisbani, E. and
             Giardina, I. and Lecomte, V. and Orlandi, A. and Parisi, G. and Procaccini, A. and
             Viale, M. and Zdravkovic, V.},
  title   = {Interaction Ruling Animal Collective Behavior Depends on Topological Rather than
             Metric Distance: Evidence from a Field Study},
  journal = {Proceedings of the National Academy of Sciences},
  volume  = {105},
  number  = {4},
  pages   = {1232--1237},
  year    = {2008},
  doi     = {10.1073/pnas.0711437105},
}""",
    ),
    Paper(
        r"Liu et al\. 2021",
        r"""@article{liu2021,
  author  = {Liu, Xingyu and Yan, Chao and Zhou, Han and Chang, Yuan and Xiang, Xiaojia and
             Tang, Dengqing},
  title   = {Towards Flocking Navigation and Obstacle Avoidance for Multi-{UAV} Systems through
             Hierarchical Weighting {Vicsek} Model},
  journal = {Aerospace},
  volume  = {8},
  number  = {10},
  pages   = {286},
  year    = {2021},
  doi     = {10.3390/aerospace8100286},
}""",
    ),
    Paper(
        r"Liu et al\. 2021, .*reference 16",
        r"""@article{liu2021drones,
  author  = {Liu, Xingyu and Xiang, Xiaojia and Chang, Yuan and Yan, Chao and Zhou, Han and
             Tang, Dengqing},
  title   = {Hierarchical Weighting {Vicsek} Model for Flocking Navigation of Drones},
  journal = {Drones},
  volume  = {5},
  pages   = {74},
  year    = {2021},
}""",
    ),
    Paper(
        r"Olfati-Saber 2006",
        r"""@article{olfatisaber2006,
  author  = {Olfati-Saber, Reza},
  title   = {Flocking for Multi-Agent Dynamic Systems: Algorithms and Theory},
  journal = {IEEE Transactions on Automatic Control},
  volume  = {51},
  number  = {3},
  pages   = {401--420},
  year    = {2006},
  doi     = {10.1109/TAC.2005.864190},
}""",
    ),
    Paper(
        r"Wu et al\. 2023",
        r"""@misc{wu2023,
  author = {Wu, Jianhui and Ji, Yuanfa and Sun, Xiyan and Liang, Weibin},
  title  = {Obstacle Boundary Point and Expected Velocity-Based Flocking of Multiagents with
            Obstacle Avoidance},
  year   = {2023},
  note   = {Research article, published 20 February 2023},
}""",
    ),
    Paper(
        r"Reynolds 1987",
        r"""@article{reynolds1987,
  author  = {Reynolds, Craig W.},
  title   = {Flocks, Herds and Schools: A Distributed Behavioral Model},
  journal = {ACM SIGGRAPH Computer Graphics},
  volume  = {21},
  number  = {4},
  pages   = {25--34},
  year    = {1987},
  doi     = {10.1145/37402.37406},
}""",
    ),
    Paper(
        r"Reynolds (1987, )?1999",
        r"""@inproceedings{reynolds1999,
  author    = {Reynolds, Craig W.},
  title     = {Steering Behaviors for Autonomous Characters},
  booktitle = {Proceedings of the Game Developers Conference},
  pages     = {763--782},
  year      = {1999},
}""",
    ),
    Paper(
        r"Couzin et al\. 2002",
        r"""@article{couzin2002,
  author  = {Couzin, Iain D. and Krause, Jens and James, Richard and Ruxton, Graeme D. and
             Franks, Nigel R.},
  title   = {Collective Memory and Spatial Sorting in Animal Groups},
  journal = {Journal of Theoretical Biology},
  volume  = {218},
  number  = {1},
  pages   = {1--11},
  year    = {2002},
  doi     = {10.1006/jtbi.2002.3065},
}""",
    ),
    Paper(
        r"Couzin et al\. 2005",
        r"""@article{couzin2005,
  author  = {Couzin, Iain D. and Krause, Jens and Franks, Nigel R. and Levin, Simon A.},
  title   = {Effective Leadership and Decision-Making in Animal Groups on the Move},
  journal = {Nature},
  volume  = {433},
  number  = {7025},
  pages   = {513--516},
  year    = {2005},
  doi     = {10.1038/nature03236},
}""",
    ),
    Paper(
        r"Cucker and Smale 2007",
        r"""@article{cuckersmale2007,
  author  = {Cucker, Felipe and Smale, Steve},
  title   = {Emergent Behavior in Flocks},
  journal = {IEEE Transactions on Automatic Control},
  volume  = {52},
  number  = {5},
  pages   = {852--862},
  year    = {2007},
  doi     = {10.1109/TAC.2007.895842},
}""",
    ),
    Paper(
        r"D'Orsogna et al\. 2006",
        r"""@article{dorsogna2006,
  author  = {D'Orsogna, M. R. and Chuang, Y. L. and Bertozzi, A. L. and Chayes, L. S.},
  title   = {Self-Propelled Particles with Soft-Core Interactions: Patterns, Stability, and
             Collapse},
  journal = {Physical Review Letters},
  volume  = {96},
  number  = {10},
  pages   = {104302},
  year    = {2006},
  doi     = {10.1103/PhysRevLett.96.104302},
}""",
    ),
    Paper(
        r"Chen and Kolokolnikov 2014",
        r"""@article{chenkolokolnikov2014,
  author  = {Chen, Yuxin and Kolokolnikov, Theodore},
  title   = {A Minimal Model of Predator--Swarm Interactions},
  journal = {Journal of the Royal Society Interface},
  volume  = {11},
  number  = {94},
  pages   = {20131208},
  year    = {2014},
  doi     = {10.1098/rsif.2013.1208},
}""",
    ),
    Paper(
        r"Fily and Marchetti 2012",
        r"""@article{fily2012,
  author  = {Fily, Yaouen and Marchetti, M. Cristina},
  title   = {Athermal Phase Separation of Self-Propelled Particles with No Alignment},
  journal = {Physical Review Letters},
  volume  = {108},
  number  = {23},
  pages   = {235702},
  year    = {2012},
  doi     = {10.1103/PhysRevLett.108.235702},
}""",
    ),
    Paper(
        r"Bechinger et al\. 2016",
        r"""@article{bechinger2016,
  author  = {Bechinger, Clemens and Di Leonardo, Roberto and L{\"o}wen, Hartmut and
             Reichhardt, Charles and Volpe, Giorgio and Volpe, Giovanni},
  title   = {Active Particles in Complex and Crowded Environments},
  journal = {Reviews of Modern Physics},
  volume  = {88},
  number  = {4},
  pages   = {045006},
  year    = {2016},
  doi     = {10.1103/RevModPhys.88.045006},
}""",
    ),
    Paper(
        r"Vasarhelyi et al\. 2018",
        r"""@article{vasarhelyi2018,
  author  = {V{\'a}s{\'a}rhelyi, G{\'a}bor and Vir{\'a}gh, Csaba and Somorjai, Gerg{\H{o}} and
             Nepusz, Tam{\'a}s and Eiben, Agoston E. and Vicsek, Tam{\'a}s},
  title   = {Optimized Flocking of Autonomous Drones in Confined Environments},
  journal = {Science Robotics},
  volume  = {3},
  number  = {20},
  pages   = {eaat3536},
  year    = {2018},
  doi     = {10.1126/scirobotics.aat3536},
}""",
    ),
    Paper(
        r"Helbing and Molnar 1995",
        r"""@article{helbing1995,
  author  = {Helbing, Dirk and Moln{\'a}r, P{\'e}ter},
  title   = {Social Force Model for Pedestrian Dynamics},
  journal = {Physical Review E},
  volume  = {51},
  number  = {5},
  pages   = {4282--4286},
  year    = {1995},
  doi     = {10.1103/PhysRevE.51.4282},
}""",
    ),
    Paper(
        r"Attanasi et al\. 2014",
        r"""@article{attanasi2014,
  author  = {Attanasi, Alessandro and Cavagna, Andrea and Del Castello, Lorenzo and Giardina, Irene
             and Grigera, Tomas S. and Jeli{\'c}, Asja and Melillo, Stefania and Parisi, Leonardo
             and Pohl, Oliver and Shen, Edward and Viale, Massimiliano},
  title   = {Information Transfer and Behavioural Inertia in Starling Flocks},
  journal = {Nature Physics},
  volume  = {10},
  number  = {9},
  pages   = {691--696},
  year    = {2014},
  doi     = {10.1038/nphys3035},
}""",
    ),
    Paper(
        r"Cavagna et al\. 2015",
        r"""@article{cavagna2015,
  author  = {Cavagna, Andrea and Del Castello, Lorenzo and Giardina, Irene and Grigera, Tomas and
             Jeli{\'c}, Asja and Melillo, Stefania and Mora, Thierry and Parisi, Leonardo and
             Silvestri, Edmondo and Viale, Massimiliano and Walczak, Aleksandra M.},
  title   = {Flocking and Turning: a New Model for Self-Organized Collective Motion},
  journal = {Journal of Statistical Physics},
  volume  = {158},
  pages   = {601--627},
  year    = {2015},
  doi     = {10.1007/s10955-014-1119-3},
}""",
    ),
    Paper(
        r"SwarmLab",
        r"""@inproceedings{soria2020,
  author    = {Soria, Enrica and Schiano, Fabrizio and Floreano, Dario},
  title     = {{SwarmLab}: a {Matlab} Drone Swarm Simulator},
  booktitle = {IEEE/RSJ International Conference on Intelligent Robots and Systems},
  pages     = {8005--8011},
  year      = {2020},
  doi       = {10.1109/IROS45743.2020.9340854},
}""",
    ),
    Paper(
        r"\bthesis\b",
        r"""@misc{flappingwing,
  title = {Research on Self-organization Behavior of the Bionic Flapping-wing Air Vehicle Cluster
           Based on Local Information Interaction},
  note  = {Bachelor thesis, in Chinese},
}""",
    ),
    Paper(
        r"Jacobs and Koessler",
        r"""@misc{jacobs,
  author = {Jacobs, Alex T. and Koessler, Jeffrey H.},
  title  = {Flocking Cars: Dynamic Behavior in Simulation \& Implementation},
  note   = {University of Arizona, ECE 516 Introduction to Robotics},
}""",
    ),
)


def cite(model: Model) -> list[str]:
    """BibTeX entries of a model's sources, its rule's own first; none if no paper is named."""
    own_entries = entries(model.rule.bibtex)
    return [*own_entries, *papers_in((model.rule.source, model.body.source))]


def papers_in(sources: Iterable[str]) -> list[str]:
    """The known papers that these words name, in their order.

    >>> [entry.partition(",")[0] for entry in papers_in(["Reynolds 1987, 1999; our own"])]
    ['@article{reynolds1987', '@inproceedings{reynolds1999']
    """
    text = "\n".join(sources)
    matches = ((re.search(paper.pattern, text), paper.bibtex) for paper in PAPERS)
    return [bibtex for at, bibtex in sorted((m.start(), b) for m, b in matches if m)]


def entries(bibtex: str) -> list[str]:
    """The entries of a text of BibTeX, each of which begins a line with `@`."""
    return [entry.strip() for entry in re.split(r"^(?=@)", bibtex, flags=re.MULTILINE)[1:]]
