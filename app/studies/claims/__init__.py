"""What a paper claims, judged by the runs."""
